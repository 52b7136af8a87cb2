"""Devices, scenes and their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Path, as_image, floats
from ._cmpg import DeviceInfo
from ._errors import UsageError


def devices() -> list[DeviceInfo]:
    """Every Vulkan device seen, usable or not.

    Raises:
        DeviceError: there is no Vulkan at all; the remedy names the package that brings a driver.
    """
    return _cmpg.devices()


class Device:
    """A Vulkan device. Passes on one device follow one another, whatever threads ask for them; the interpreter is free meanwhile.

    Args:
        select: an index into devices(), or a part of a name; "" takes the best.
        communicator: of mpi4py, such as MPI.COMM_WORLD. Its ranks share the passes on the device: each makes one, makes the same renderers and recoveries
            on it and asks for the same passes in the same order, and all get the same results: the bits of one process alone. Recovery.save() and
            save_guide() write on the first rank alone. "" takes another graphics processor for each rank of a machine that has several. The device keeps
            a duplicate of the communicator until the process ends.

    Raises:
        DeviceError: none is usable or meant, or it computes wrong results; ranks have different devices or drivers, or were started by another MPI than mpi4py's.
        UsageError: the communicator is none, was freed, or connects two groups.
    """

    def __init__(self, select: str | int = "", *, communicator: Any = None) -> None:
        if communicator is not None:
            from ._mpi import Ranks

            communicator = Ranks(communicator)
        self._handle = _cmpg.Device(str(select), communicator)

    @property
    def info(self) -> DeviceInfo:
        """Name, driver and type."""
        return self._handle.info()

    @property
    def memory_in_use(self) -> int:
        """Bytes of device memory allocated now."""
        return self._handle.memory_in_use()

    @property
    def memory_peak(self) -> int:
        """The most bytes of device memory that ever were."""
        return self._handle.memory_peak()

    def __repr__(self) -> str:
        return f"<cmpg.Device {self.info.name}>"


class Parameter:
    """A parameter of a scene: its name, shape and range, and its values."""

    def __init__(self, scene: Scene, info: _cmpg.ParameterInfo) -> None:
        self._scene = scene
        self.name: str = info.name
        #: "baseColor", "roughness", "metallic", "specular", "emission", "normal", "clearcoat", "clearcoatRoughness", "anisotropy", "sheenRoughness", "sheenColor", "weight" or "radiance"
        self.slot: str = info.slot
        #: (height, width, channels)
        self.shape: tuple[int, int, int] = info.shape
        self.lowest: float = info.lowest
        #: may be infinite
        self.highest: float = info.highest

    @property
    def values(self) -> Image:
        """The current values, float32 of `shape`: a copy. Assigning sets them: an array of `shape`, one value per channel, or a number.

        Raises:
            UsageError: another shape, or values out of range.
        """
        return as_image(self._scene._handle.values(self.name))

    @values.setter
    def values(self, values: npt.ArrayLike) -> None:
        array = floats(values)
        if array.ndim > 1 and array.shape != self.shape:
            raise UsageError(f"{self.name} has the shape {self.shape}, not {array.shape}", "", "give that shape, one value per channel, or a number")
        self._scene._handle.set(self.name, array)
        self._scene._revision += 1
        self._scene._changed.add(self.name)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.values, dtype=dtype)

    def __dlpack__(self, **options: Any) -> Any:
        return self.values.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.values.__dlpack_device__()

    def _repr_png_(self) -> bytes:
        return self.values.png()

    def __repr__(self) -> str:
        return f"<cmpg.Parameter {self.name} {self.shape} in [{self.lowest:g}, {self.highest:g}]>"


class SurfacePoint(NamedTuple):
    """What a camera sees first at a place of an image."""

    position: tuple[float, float, float]
    #: the triangle's normal, towards the camera
    normal: tuple[float, float, float]
    #: along the ray
    distance: float
    material: str


class Scene:
    """A scene, glTF or Mitsuba XML. It owns the values of its parameters: renderers follow them, a recovery begins at them and keeps its own.

    scene["painting.baseColor"] is a Parameter; scene["painting.baseColor"] = array sets its values.

    Args:
        file: .gltf, .glb or .xml (Mitsuba).
        environment: latitude-longitude picture of the surroundings, in place of the scene's own, or of none.
        environment_rotation: of that picture about +y, in degrees.
        define: values of the variables of a Mitsuba scene, by name.
        filter: reconstruction filter of all cameras, in place of the scene's own: "box", "tent", "gaussian", or with the radius of a tent
            or the standard deviation of a Gaussian in pixels, "tent:1.5", "gaussian:0.7".

    Raises:
        UsageError: there is no such filter.
        InputError: the file is missing, malformed or too large.
    """

    def __init__(self, file: Path, *, environment: Path | None = None, environment_rotation: float = 0,
                 define: Mapping[str, object] | None = None, filter: str | None = None) -> None:
        self._handle = _cmpg.Scene(file, environment or "", environment_rotation, {k: str(v) for k, v in (define or {}).items()},
                                    filter)
        self._revision = 0
        self._changed: set[str] = set()  # names of what was set
        self._device: Device | None = None
        self._renderers: dict[Any, Any] = {}  # of cmpg.torch

    def copy(self) -> Scene:
        """The same scene with values of its own."""
        other = Scene.__new__(Scene)
        other._handle = self._handle.copy()
        other._revision = 0
        other._changed = set(self._changed)
        other._device = self._device
        other._renderers = {}
        return other

    @property
    def device(self) -> Device:
        """Where renderers and recoveries of this scene run that were given no device: the best one, opened when it is first needed."""
        if self._device is None:
            self._device = Device()
        return self._device

    @property
    def source(self) -> str:
        """The file it came from."""
        return self._handle.source()

    @property
    def warnings(self) -> list[str]:
        """What the file has that is not rendered, and the like."""
        return self._handle.warnings()

    @property
    def max_depth(self) -> int:
        """Segments of a path that the file asks for, else 8."""
        return self._handle.max_depth()

    @property
    def cameras(self) -> dict[str, float | None]:
        """Aspect ratio (width / height, None where the file has none) by name."""
        return dict(self._handle.cameras())

    def pick(self, x: float, y: float, *, camera: str = "", width: int = 0, height: int = 0) -> SurfacePoint | None:
        """The surface at a place of an image of that size; (0, 0) is the top left corner of the top left pixel. None where there is none.

        Raises:
            UsageError: there is no such camera.
        """
        found = self._handle.pick(x, y, camera, width, height)
        return None if found is None else SurfacePoint(*found)

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters by name."""
        return {info.name: Parameter(self, info) for info in self._handle.parameters()}

    def select(self, glob: str) -> list[str]:
        """Names of the parameters that a glob selects (* any characters, ? one).

        Raises:
            UsageError: there is none.
        """
        return self._handle.select(glob)

    def __getitem__(self, name: str) -> Parameter:
        return Parameter(self, self._handle.parameter(name))

    def __setitem__(self, name: str, values: npt.ArrayLike) -> None:
        self[name].values = values

    def export(self, folder: Path) -> None:
        """Writes folder/scene.gltf with the values that were set (textures as 8-bit PNG), and the exact ones as folder/parameters/<name>.exr.

        Raises:
            OutputError: that fails.
        """
        self._handle.export(folder)

    def __repr__(self) -> str:
        return f"<cmpg.Scene {self.source}: {len(self.parameters)} parameters, cameras {', '.join(self.cameras)}>"
