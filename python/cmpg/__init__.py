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

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

try:
    from . import _cmpg
except ImportError as error:
    if "libvulkan" in str(error):  # which no wheel holds: it belongs to the machine's drivers
        raise ImportError("there is no Vulkan loader: install the package libvulkan1, and mesa-vulkan-drivers where there is no driver either") from error
    raise
from ._cmpg import DeviceInfo, PassReport, RecoveryStep
from ._errors import DeviceError, Error, InputError, NumericalError, OutputError, UsageError

__all__ = [
    "Device", "DeviceInfo", "DeviceError", "Error", "Image", "InputError", "NumericalError", "OutputError", "Parameter", "PassReport",
    "Recovery", "RecoveryStep",
    "Renderer", "Scene", "UsageError", "devices", "load_image",
]

Path = Union[str, "os.PathLike[str]"]
Names = Union[str, Sequence[str]]


def _floats(values: Any) -> npt.NDArray[np.float32]:
    """Any array as contiguous float32: itself where it is that. Arrays of other libraries come by DLPack, without a copy where they lie on the host."""
    if not isinstance(values, np.ndarray) and hasattr(values, "__dlpack__"):
        if getattr(values, "requires_grad", False):  # a tensor's graph would be cut in silence
            raise UsageError("values that take part in a derivative would be cut off from it", "", "use cmpg.torch.render(), or give values.detach()")
        try:
            values = np.from_dlpack(values)
        except (BufferError, RuntimeError, TypeError) as error:
            raise UsageError("an array of another library cannot be read", str(error), "copy it to the host as float32") from error
    return np.ascontiguousarray(values, dtype=np.float32)


def _names(names: Names) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


class Image(np.ndarray):
    """An array of (height, width, channels), float32, linear, that shows itself as a picture in a notebook."""

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if array.ndim == 0 else array.view(Image)  # a sum is a number, no picture

    def save(self, file: Path, exposure: float = 0) -> None:
        """Writes .exr (exact) or .png (8-bit sRGB of values times 2^exposure, clamped to [0, 1]).

        Raises:
            UsageError: another ending.
            OutputError: the file cannot be written.
        """
        _cmpg.save_image(file, _floats(self), exposure)

    def png(self, exposure: float = 0) -> bytes:
        """The bytes of such a PNG file."""
        return _cmpg.encode_png(_floats(self), exposure)

    def _repr_png_(self) -> bytes | None:
        return self.png() if self.ndim == 3 and self.shape[2] in (1, 3) else None


def _image(array: npt.NDArray[np.float32]) -> Image:
    return array.view(Image)


def load_image(file: Path) -> Image:
    """Reads .exr, .hdr, .png or .jpg as (height, width, 3); 8-bit files are decoded from sRGB.

    Raises:
        InputError: the file is missing or malformed.
    """
    return _image(_cmpg.load_image(file))


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

    Raises:
        DeviceError: none is usable or meant, or it computes wrong results.
    """

    def __init__(self, select: str | int = "") -> None:
        self._handle = _cmpg.Device(str(select))

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
        #: "baseColor", "roughness", "metallic", "specular", "emission", "normal", "clearcoat", "clearcoatRoughness" or "radiance"
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
        return _image(self._scene._handle.values(self.name))

    @values.setter
    def values(self, values: npt.ArrayLike) -> None:
        array = _floats(values)
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


class Scene:
    """A scene, glTF or Mitsuba XML. It owns the values of its parameters: renderers follow them, a recovery begins at them and keeps its own.

    scene["painting.baseColor"] is a Parameter; scene["painting.baseColor"] = array sets its values.

    Args:
        file: .gltf, .glb or .xml (Mitsuba).
        environment: latitude-longitude picture of the surroundings, in place of the scene's own, or of none.
        environment_rotation: of that picture about +y, in degrees.
        define: values of the variables of a Mitsuba scene, by name.

    Raises:
        InputError: the file is missing, malformed or too large.
    """

    def __init__(self, file: Path, *, environment: Path | None = None, environment_rotation: float = 0,
                 define: Mapping[str, object] | None = None) -> None:
        self._handle = _cmpg.Scene(file, environment or "", environment_rotation, {k: str(v) for k, v in (define or {}).items()})
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


def _paths(max_depth: int, sampling: str, pixel_sampling: str, roulette: str, positivize: bool, no_nee: bool, memory: int, guide_memory: int,
           sampler: str, load_guide: Path | None, keep_guide: bool, expert: Mapping[str, float] | None) -> Any:
    return _cmpg.PathOptions(max_depth=max_depth, sampling=sampling, pixel_sampling=pixel_sampling, roulette=roulette, positivize=positivize,
                             no_nee=no_nee, memory=memory, guide_memory=guide_memory, sampler=sampler, load_guide=load_guide or "",
                             keep_guide=keep_guide, expert={name: float(value) for name, value in (expert or {}).items()})


class Renderer:
    """Images of a scene and their derivatives. Every pass reads the scene's current values.

    Values of the parameters in `param` may change at little cost; a change of any other has the renderer made anew, without its guide.

    Args:
        scene: what is rendered.
        param: names or globs of the parameters that derivatives may be asked for.
        device: where; None: the scene's.
        max_depth: segments of a path, 1 = lights seen directly alone; 0: the scene's.
        sampling: how directions are drawn: "bsdf", "primal", "differential", "uniform", "conditional" or "auto".
        pixel_sampling: samples of backward(): "uniform", or "adjoint": more where the adjoint is large.
        roulette: of backward() after learning passes: "off", or "adjoint": ends and splits paths by what the guide expects of them.
        positivize: derivative passes in two halves, one for each sign of the derivative.
        no_nee: no light sampling; emitters are only found by chance.
        memory: MiB of device memory for a pass, beside the scene and its parameters.
        guide_memory: MiB of device memory for the guide.
        sampler: random numbers: "sobol" (Owen-scrambled), or "independent".
        load_guide: a file of save_guide(), from which passes draw and learning passes continue.
        keep_guide: to be saved: learn a guide even where no pass would draw from it.
        expert: guide_share (of directions, drawn from the guide), roulette_effort, cell_records, direction_share, forgetting, all_features, as of
            the command line.

    Raises:
        UsageError: an unknown parameter or an option out of range.
        DeviceError: memory is short.
    """

    def __init__(self, scene: Scene, param: Names = (), *, device: Device | None = None, max_depth: int = 0, sampling: str = "auto",
                 pixel_sampling: str = "adjoint", roulette: str = "adjoint", positivize: bool = False, no_nee: bool = False, memory: int = 1024,
                 guide_memory: int = 64, sampler: str = "sobol", load_guide: Path | None = None,
                 keep_guide: bool = False, expert: Mapping[str, float] | None = None) -> None:
        paths = _paths(max_depth, sampling, pixel_sampling, roulette, positivize, no_nee, memory, guide_memory, sampler, load_guide, keep_guide, expert)
        #: what the last pass did: samples, error, seconds, method; None before the first
        self.report: PassReport | None = None
        self._scene = scene
        self._handle = _cmpg.Renderer((device or scene.device)._handle, scene._handle, _names(param), paths)

    @property
    def parameters(self) -> list[str]:
        """Names of what derivatives may be asked for, globs expanded."""
        return [info.name for info in self._handle.parameters()]

    def render(self, *, camera: str = "", width: int = 0, height: int = 0, spp: int = 0, seed: int = 0, train: int = 0, train_spp: int = 0,
               frozen: bool = False, error_target: float = 0, time_budget: float = 0, batches: int = 0, layers: bool = False) -> Image:
        """Radiance, (height, width, 3).

        Args:
            camera: its name; "": the first.
            width, height: in pixels; 0: from the other one by the camera's aspect ratio; both 0: 512 wide.
            spp: samples per pixel; 0: 64, or up to 65536 under an error target or a time budget.
            seed: equal seeds, equal random numbers; images and derivatives of one seed have independent ones.
            train: learning passes before this one. They learn a guide anew, from which this pass and those after it draw.
            train_spp: samples per pixel of each; 0: as many as the pass has.
            frozen: draws from no guide.
            error_target: sample until |standard error| / |image| is this small (0.01 is 1 %); `spp` is the most. 0: no target.
            time_budget: sample for so many seconds, learning included; 0: no budget.
            batches: divide the samples among so many batches, whose spread tells the error in `report`; 0: 8 with a target or budget, else none.
            layers: `report.layers()` then has what the camera sees first and what the guide does there: "normal" (height, width, 3), "depth", "albedo" ...

        Raises:
            UsageError: an unknown camera, or an option out of range.
        """
        image, self.report = self._handle.render(
            _cmpg.PassOptions(camera, width, height, spp, seed, train, train_spp, frozen, error_target, time_budget, batches, layers))
        return _image(image)

    def forward(self, direction: Mapping[str, npt.ArrayLike], *, camera: str = "", width: int = 0, height: int = 0, spp: int = 0, seed: int = 0,
                train: int = 0, train_spp: int = 0, frozen: bool = False, error_target: float = 0, time_budget: float = 0, batches: int = 0,
                layers: bool = False) -> Image:
        """The derivative of the image along a direction, (height, width, 3): the sum over the parameters of dI/dp . v.

        Args:
            direction: v by the name of the parameter: an array of its shape, one value per channel, or a number.
            frozen: with the random numbers of render() with the same seed, for comparison with finite differences; from no guide.
            The others as in render().
        """
        given = [(name, self._direction(name, values)) for name, values in direction.items()]
        image, self.report = self._handle.forward(
            given, _cmpg.PassOptions(camera, width, height, spp, seed, train, train_spp, frozen, error_target, time_budget, batches, layers))
        return _image(image)

    def _direction(self, name: str, values: npt.ArrayLike) -> npt.NDArray[np.float32]:
        return _floats(np.broadcast_to(_floats(values), self._scene[name].shape))

    def check(self, name: str, direction: npt.ArrayLike = 1, *, camera: str = "", width: int = 0, height: int = 0, spp: int = 16, spp_gradient: int = 0,
              seed: int = 0) -> dict[str, Any]:
        """The derivative along a direction of one parameter against finite differences of images, 16 times each.

        Args:
            name: the parameter.
            direction: an array of its shape, one value per channel, or a number.
            width, height: both 0: 128 wide.
            spp, spp_gradient: samples per pixel of each of up to 200 images, and of each of 16 derivatives (0: as many).

        Returns:
            "agrees": whether no mean of a channel or of a block of pixels differs by more than chance and the errors of differences explain; and
            "comparisons": these, each with "what", "forward", "finite", "standard_error", "relative_error", "power" (the least relative error that would
            stand out) and "probability" (of so large a deviation by chance; below "threshold" it is a disagreement).
        """
        options = _cmpg.PassOptions(camera, width, height, spp, seed, 0, 0, True, 0, 0, 0, False)
        return self._handle.check(name, self._direction(name, direction), options, spp_gradient)

    def save_guide(self, file: Path) -> None:
        """Writes what was learned, for `load_guide`.

        Raises:
            UsageError: nothing was learned.
            OutputError: it cannot be written.
        """
        self._handle.save_guide(file)

    def backward(self, adjoint: npt.ArrayLike, *, camera: str = "", spp: int = 0, seed: int = 0, train: int = 0, train_spp: int = 0,
                 frozen: bool = False, error_target: float = 0, time_budget: float = 0, batches: int = 0) -> dict[str, Image]:
        """adjoint^T . dI/dp of every parameter in `param`, by name, in the parameter's shape.

        Args:
            adjoint: (height, width, 3): the derivative of a scalar by every pixel. The pass has its size.
            frozen: with the random numbers of render() with the same seed, equally many samples in every pixel and no guide, for comparison with
                finite differences. In an optimisation their noise would be correlated with the image's.
            The others as in render().
        """
        gradients, self.report = self._handle.backward(
            _floats(adjoint), _cmpg.PassOptions(camera, 0, 0, spp, seed, train, train_spp, frozen, error_target, time_budget, batches, False))
        return {name: _image(gradient) for name, gradient in gradients.items()}


class Recovery(Iterator[RecoveryStep]):
    """Recovers parameters of a scene from images of it: an iterator over its steps.

    It takes a copy of the scene: its values are where the recovery begins, and stay as they are until apply().

    Args:
        scene: where it begins.
        target: what a camera saw: an array (height, width, 3) or a file; or several, by the camera's name. Alpha of a file weights its pixels;
            clipped pixels of 8-bit files and values that are not finite have no weight.
        param: names or globs of what is recovered.
        device: where; None: the scene's.
        steps: of the whole recovery and its schedule.
        spp: samples per pixel of the image of the first step.
        spp_gradient: of the derivative pass of a step.
        spp_difference: that bring the image of the step before up to date; 0: every step renders its own of `spp`.
        loss: "mse", "l1", "smape" or "relative-mse".
        optimizer: "auto", "gauss-newton", "adam" or "sgd".
        rate: a number for all slots, or a number by the name of the slot, such as {"roughness": 0.01}.
        schedule: of the rate: "constant", "cosine" or "exponential".
        final_rate: what the schedule has multiplied the rate by at the last step.
        prior: what is known of textures: differences of neighbouring texels, root mean square d over the n channels, are as likely
            as exp(-prior n d); 0: nothing.
        total_variation: weight of the total variation of textures.
        views_per_step: of several targets; 0: all.
        warm_up: first steps, which only learn the guide.
        freeze: step from which on the guide stays as it is; 0: none.
        error_target: the gradient of each step is sampled until |standard error| / |gradient| is this small; `spp_gradient`, at least 8, is the most.
        mask: weights in [0, 1] of the targets' pixels, (height, width), or for targets that are files the file of an image.
        target_exposure: targets are multiplied by 2^target_exposure.
        The others as in Renderer.

    Raises:
        UsageError: options that make no sense, or unknown names.
        InputError: a target that cannot be read or does not fit.
    """

    def __init__(self, scene: Scene, target: npt.ArrayLike | Path | Mapping[str, npt.ArrayLike | Path], param: Names, *, device: Device | None = None,
                 steps: int = 200, spp: int = 16, spp_gradient: int = 4, spp_difference: int = 8, seed: int = 0, loss: str = "mse",
                 optimizer: str = "auto", rate: float | Mapping[str, float] | None = None, schedule: str = "constant", final_rate: float = 0.1,
                 prior: float = 8, total_variation: float = 0, views_per_step: int = 0, warm_up: int = 0, freeze: int = 0,
                 error_target: float = 0, mask: npt.ArrayLike | Path | None = None, target_exposure: float = 0, max_depth: int = 0, sampling: str = "auto",
                 pixel_sampling: str = "adjoint", roulette: str = "adjoint", positivize: bool = False, no_nee: bool = False, memory: int = 1024,
                 guide_memory: int = 64, sampler: str = "sobol", load_guide: Path | None = None,
                 keep_guide: bool = False, expert: Mapping[str, float] | None = None) -> None:
        paths = _paths(max_depth, sampling, pixel_sampling, roulette, positivize, no_nee, memory, guide_memory, sampler, load_guide, keep_guide, expert)
        views = target if isinstance(target, Mapping) else {"": target}
        targets = [_target(image, camera, mask, target_exposure) for camera, image in views.items()]
        rates = [] if rate is None else list(rate.items()) if isinstance(rate, Mapping) else [("", float(rate))]
        self._handle = _cmpg.Recovery(
            (device or scene.device)._handle, scene._handle, targets, _names(param), paths, steps=steps, spp=spp, spp_gradient=spp_gradient,
            spp_difference=spp_difference, seed=seed, loss=loss, optimizer=optimizer, rates=rates, schedule=schedule, final_rate=final_rate,
            prior=prior, total_variation=total_variation, views_per_step=views_per_step, warm_up=warm_up, freeze=freeze, error_target=error_target)
        self._infos = {info.name: info for info in self._handle.parameters()}

    def __iter__(self) -> Recovery:
        return self

    def __next__(self) -> RecoveryStep:
        if self.done:
            raise StopIteration
        return self.step()

    def step(self) -> RecoveryStep:
        """One step, also beyond `steps`. One that Ctrl-C ends has changed nothing and can be done again.

        Raises:
            NumericalError: no entry of the gradient is finite.
            DeviceError: the device is lost.
        """
        return self._handle.step()

    @property
    def steps_done(self) -> int:
        """Steps done so far, those before resume() included."""
        return self._handle.steps()

    @property
    def done(self) -> bool:
        """Whether all steps are done."""
        return self._handle.done()

    @property
    def parameters(self) -> list[str]:
        """Names of what is recovered, globs expanded."""
        return list(self._infos)

    def _info(self, name: str) -> _cmpg.ParameterInfo:
        if name not in self._infos:
            raise UsageError(f"{name} is not recovered", f"recovered are {', '.join(self._infos)}", "name it", ["param"])
        return self._infos[name]

    def __getitem__(self, name: str) -> Image:
        """The current values of a parameter, in its shape: a copy."""
        return _image(self._handle.values(self._info(name)))

    def gradient(self, name: str) -> Image:
        """Of the last step, regulariser included, in the parameter's shape; zeros before the first."""
        return _image(self._handle.gradient(self._info(name)))

    def image(self, target: int = 0, spp: int = 64) -> Image:
        """What the camera of a target (by its number) sees at the current values, (height, width, 3)."""
        return _image(self._handle.image(target, spp))

    @property
    def errors(self) -> dict[str, Any]:
        """Under an error target: how many "gradients" there were, how many of them "missed" it, and the "worst" error of these."""
        return self._handle.errors()

    def save_guide(self, file: Path) -> None:
        """Writes what was learned, for `load_guide`.

        Raises:
            UsageError: nothing is learned.
            OutputError: it cannot be written.
        """
        self._handle.save_guide(file)

    def apply(self, scene: Scene) -> None:
        """Puts the current values into a scene: that it was made of, or a copy of it."""
        self._handle.apply(scene._handle)
        scene._revision += 1
        scene._changed.update(self._infos)

    def save(self, folder: Path) -> None:
        """Writes all that resume() needs, and keeps the one before.

        Raises:
            OutputError: that fails.
        """
        self._handle.save(folder)

    def resume(self, folder: Path) -> bool:
        """Continues from what save() wrote to what the saved recovery would have found, bit for bit on the same device.

        Returns:
            False where the folder has nothing of the kind.

        Raises:
            InputError: it is of another recovery; the first difference is named.
        """
        return self._handle.resume(folder)


def _target(image: Any, camera: str, mask: Any, exposure: float) -> Any:
    if isinstance(image, (str, os.PathLike)):
        if mask is not None and not isinstance(mask, (str, os.PathLike)):
            raise UsageError("a target that is a file takes a mask that is a file", "", "load the target: cmpg.load_image(file)", ["mask"])
        return _cmpg.Target.load(image, camera, "" if mask is None else mask, exposure)
    if isinstance(mask, (str, os.PathLike)):
        mask = load_image(mask).mean(axis=2)
    return _cmpg.Target(_floats(image) * np.float32(2.0**exposure), camera, None if mask is None else _floats(mask))
