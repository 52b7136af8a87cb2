"""cmpg: a differentiable path tracer in Vulkan compute.

Images and values are numpy arrays of float32, linear, row 0 on top: an image has shape (height, width, 3), a parameter (height, width, channels), a
constant (1, 1, channels). Keyword arguments are the options of the command line and have their defaults.

    import cmpg
    scene = cmpg.Scene("scenes/box/scene.gltf")
    scene["painting.baseColor"] = 0.5
    recovery = cmpg.Recovery(scene, "scenes/box/target.exr", param="painting.baseColor", steps=20)
    for step in recovery:
        print(step)
    recovery.apply(scene)
"""

from __future__ import annotations

try:
    from . import _cmpg
except ImportError as error:
    if "libvulkan" in str(error):  # which no wheel holds: it belongs to the machine's drivers
        raise ImportError("there is no Vulkan loader: install the package libvulkan1, and mesa-vulkan-drivers where there is no driver either") from error
    raise
from ._arrays import Image, load_image
from ._cmpg import DeviceInfo, PassReport, RecoveryProgress, RecoveryStep
from ._errors import DeviceError, Error, InputError, NumericalError, OutputError, UsageError
from ._film import Film
from ._guide import Guide, GuidePoint
from ._recovery import Recovery, loss_of
from ._renderer import Renderer
from ._scene import Camera, Device, Parameter, Scene, SurfacePoint, devices

__version__: str = _cmpg.__version__

__all__ = [
    "Camera", "Device", "DeviceInfo", "DeviceError", "Error", "Film", "Guide", "GuidePoint", "Image", "InputError", "NumericalError", "OutputError", "Parameter",
    "PassReport", "Recovery", "RecoveryProgress", "RecoveryStep", "Renderer", "Scene", "SurfacePoint", "UsageError", "devices", "load_image", "loss_of",
]

for _public in (Camera, Device, Film, Guide, GuidePoint, Image, Parameter, Recovery, Renderer, Scene, SurfacePoint, devices, load_image, loss_of):
    _public.__module__ = "cmpg"  # where users find them
