"""Devices, scenes and their parameters."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Names, Path, as_image, floats, made, names_of
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
        self.lowest: float = info.lowest
        #: may be infinite
        self.highest: float = info.highest

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, channels)"""
        return self._scene._handle.parameter(self.name).shape

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
            raise UsageError(f"{self.name} has the shape {self.shape}, not {array.shape}", "",
                             "give that shape, one value per channel, or a number; Scene.resize changes it")
        self._scene._handle.set(self.name, array)
        self._scene._note([self.name])

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


@dataclasses.dataclass(frozen=True, eq=False)
class Camera:
    """A camera of a scene, as Scene.camera() gives it, or moved: passes, picks and targets take it in place of a name.

    look_at() moves it. dataclasses.replace(camera, yfov=0.5) changes anything else.

    Attributes:
        name: of the scene's camera that is moved; where the scene has none of that name, its first.
        to_world: (4, 4), from the camera to the world. Its columns are the directions to the camera's right, above it and behind it, then its place, in
            the scene's units. It looks against the third.
        orthographic: whether rays are parallel.
        yfov: of a perspective camera: the angle of the picture's height in radians, above 0 and below pi.
        ymag: of an orthographic camera: half the picture's height in the scene's units, above 0.
        aspect: width / height of the picture where nothing else is asked for, above 0; None: as the file says, if it does.
    """

    name: str
    to_world: npt.NDArray[np.float32]
    orthographic: bool = False
    yfov: float = 0.8
    ymag: float = 1
    aspect: float | None = None

    def look_at(self, place: npt.ArrayLike, target: npt.ArrayLike, up: npt.ArrayLike = (0, 1, 0)) -> Camera:
        """The same camera at a place, looking at a target: points (x, y, z) of the scene. `up` is a direction that is above in the picture.

        Raises:
            UsageError: the points are the same, or `up` is the direction from one to the other.
        """
        at = np.asarray(place, dtype=np.float64)
        back = at - np.asarray(target, dtype=np.float64)
        right = np.cross(np.asarray(up, dtype=np.float64), back)
        if not (back @ back > 0 and right @ right > 1e-12 * (back @ back)):
            raise UsageError("a camera cannot look there", "place and target are the same, or `up` is the direction from one to the other",
                             "choose another place, target or up", ["camera"])
        above = np.cross(back, right)
        columns = [right / np.linalg.norm(right), above / np.linalg.norm(above), back / np.linalg.norm(back), at]
        pose = np.eye(4, dtype=np.float32)
        pose[:3] = np.stack(columns, axis=1)
        return dataclasses.replace(self, to_world=pose)

    def _info(self) -> _cmpg.CameraInfo:
        columns = np.asarray(self.to_world, dtype=np.float32).T
        aspect = None if self.aspect is None else float(self.aspect)
        return _cmpg.CameraInfo(self.name, columns.ravel().tolist(), bool(self.orthographic), float(self.yfov), float(self.ymag), aspect)


def view_of(camera: str | Camera) -> tuple[str, _cmpg.CameraInfo | None]:
    """The name of a camera, or that camera moved."""
    return ("", camera._info()) if isinstance(camera, Camera) else (camera, None)


def _given_options(environment: Path | None, rotation: float, define: Mapping[str, str], filter: str | None) -> dict[str, Any]:
    """What a scene was given beside its file, as options of a run.json."""
    options: dict[str, Any] = {}
    if environment:
        options |= {"environment": os.fspath(environment), "environment-rotation": float(rotation)}
    if define:
        options["define"] = [f"{name}={value}" for name, value in define.items()]
    if filter is not None:
        options["filter"] = filter
    return options


class SurfacePoint(NamedTuple):
    """What a camera sees first at a place of an image. Lengths are in the scene's units."""

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
        definitions = {name: str(value) for name, value in (define or {}).items()}
        self._handle = _cmpg.Scene(file, environment or "", environment_rotation, definitions, filter)
        self._revision = 0
        self._given = _given_options(environment, environment_rotation, definitions, filter)
        self._changed: set[str] = set()  # names of what was set
        self._resized: set[str] = set()  # and of what has another size than in the file
        self._device: Device | None = None
        self._renderers: dict[Any, Any] = {}  # of cmpg.torch

    def copy(self) -> Scene:
        """The same scene with values of its own."""
        other = Scene.__new__(Scene)
        other._handle = self._handle.copy()
        other._revision = 0
        other._given = self._given
        other._changed = set(self._changed)
        other._resized = set(self._resized)
        other._device = self._device
        other._renderers = {}
        return other

    def _note(self, names: Iterable[str]) -> None:
        """These parameters have other values now."""
        self._revision += 1
        self._changed.update(names)

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

    def camera(self, name: str = "") -> Camera:
        """One of the cameras; "": the first.

        Raises:
            UsageError: there is no such camera.
        """
        info = self._handle.camera(name)
        pose = np.array(info.columns, dtype=np.float32).reshape(4, 4).T.copy()
        return Camera(info.name, pose, info.orthographic, info.yfov, info.ymag, info.aspect)

    def pick(self, x: float, y: float, *, camera: str | Camera = "", width: int = 0, height: int = 0) -> SurfacePoint | None:
        """The surface at a place of an image of that size; (0, 0) is the top left corner of the top left pixel. None where there is none.

        Args:
            x, y: in pixels, from the left and from the top.
            camera, width, height: as in Renderer.render().

        Raises:
            UsageError: there is no such camera, or its pose is not finite.
        """
        name, moved = view_of(camera)
        found = made(self._handle.pick, x=x, y=y, camera=name, moved=moved, width=width, height=height)
        return None if found is None else SurfacePoint(*found)

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters by name."""
        return {info.name: Parameter(self, info) for info in self._handle.parameters()}

    def select(self, globs: Names) -> list[str]:
        """Names of the parameters that globs select (* any characters, ? one), each once.

        Raises:
            UsageError: there is none of a glob.
        """
        return list(dict.fromkeys(name for glob in names_of(globs) for name in self._handle.select(glob)))

    def __getitem__(self, name: str) -> Parameter:
        if not isinstance(name, str):
            raise UsageError(f"a parameter is asked for by {name!r}", "", "give its name", ["parameters"])
        return Parameter(self, self._handle.parameter(name))

    def __contains__(self, name: object) -> bool:
        return name in self.parameters

    def __iter__(self) -> Iterator[str]:
        """Names of all parameters."""
        return iter(self.parameters)

    def __setitem__(self, name: str, values: npt.ArrayLike) -> None:
        self[name].values = values

    def resize(self, name: str, width: int, height: int) -> None:
        """Gives a parameter a texture of this size: of a constant, or resampled. The surface looks the same as far as texels allow.

        Args:
            name: the parameter.
            width, height: texels along each edge, from 1 to 8192.

        Raises:
            UsageError: there is no place for a texture: meshes without texture coordinates, normals without a normal map, anisotropy, an environment of
                one colour.
        """
        made(self._handle.resize, name=name, width=width, height=height)
        self._resized.add(name)
        self._note([name])

    def export(self, folder: Path) -> None:
        """Writes folder/scene.gltf with the values that were set (textures as 8-bit PNG), and the exact ones as folder/parameters/<name>.exr.

        Raises:
            OutputError: that fails.
        """
        self._handle.export(folder)

    def __repr__(self) -> str:
        return f"<cmpg.Scene {self.source}: {len(self.parameters)} parameters, cameras {', '.join(self.cameras)}>"
