"""Recoveries of parameters from images."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Names, Path, as_image, floats, load_image, made, names_of
from ._callbacks import weakly
from ._cmpg import PassReport, RecoveryProgress, RecoveryStep
from ._errors import UsageError
from ._film import Film
from ._renderer import Renderer, path_options
from ._scene import Camera, Device, Scene, view_of

MOST_TARGET_BYTES = _cmpg.Target.most_bytes

Picture = Union[npt.ArrayLike, Path]
Targets = Union[Picture, Mapping[str, Picture], Mapping[Camera, Picture], Mapping[Union[str, Camera], Picture]]
Masks = Targets


class Recovery(Iterator[RecoveryStep]):
    """Recovers parameters of a scene from images of it: an iterator over its steps.

    It takes a copy of the scene: its values are where the recovery begins, and stay as they are until apply().

    Args:
        scene: where it begins.
        target: what a camera saw: a linear array (height, width, 3) or a file; or several, by the camera's name or by a Camera. Alpha of a file
            weights its pixels; pixels that are not finite have no weight, and the largest values of .png and .jpg are lower bounds. Files
            beyond 256 MiB in all are read when a step sees them.
        param: names or globs of what is recovered.
        device: where; None: the scene's.
        steps: of the whole recovery and its schedule.
        spp: samples per pixel of the image of the first step.
        spp_gradient: of the derivative pass of a step.
        spp_difference: at most, that bring the image of the step before up to date: all where what is left of a squared loss is the image's noise, half
            where it is not and steps are long, 2 where neither; 0: every step renders its own of `spp`. Of all three numbers a pixel takes fewer, down to
            a quarter, where textures of colour or light are recovered whose texels cover more than four pixels.
        loss: "mse", "l1", "smape" or "relative-mse".
        optimizer: "auto", "gauss-newton", "adam" or "sgd".
        rate: a number for all slots, or a number by the name of the slot, such as {"roughness": 0.01}.
        schedule: of the rate: "constant", "cosine" or "exponential".
        final_rate: what the schedule has multiplied the rate by at the last step.
        prior: what is known of textures: differences of neighbouring texels, root mean square d over the n channels, are as likely
            as exp(-prior n (d^3 / 4)^(1/4)), or less where the texture is fine or in the shade; 0: nothing.
        total_variation: weight of the total variation of textures.
        views_per_step: of several targets, at most; 0: all; where Gauss-Newton recovers textures and no constants, of four and more at first one, and
            of fewer one by maps of roughness and other shapes of lobes alone.
        warm_up: first steps, which only learn the guide.
        freeze: step from which on the guide stays as it is; 0: none.
        error_target: the gradient of each step is sampled until |standard error| / |gradient| is this small; `spp_gradient`, at least 8, is the most.
        mask: weights in [0, 1] of the targets' pixels, (height, width), or for targets that are files the file of an image; or several, by the camera
            as the targets are: others have none.
        target_exposure: targets are multiplied by 2^target_exposure.
        width, height: targets are averaged to so many pixels; 0: as many as they have, or as keep their shape.
        The others as in Renderer.

    Raises:
        UsageError: options that make no sense, or unknown names.
        InputError: a target that cannot be read or does not fit.
    """

    def __init__(self, scene: Scene, target: Targets, param: Names, *, device: Device | None = None,
                 steps: int = 200, spp: int = 16, spp_gradient: int = 4, spp_difference: int = 12, seed: int = 0, loss: str = "mse",
                 optimizer: str = "auto", rate: float | Mapping[str, float] | None = None, schedule: str = "constant", final_rate: float = 0.1,
                 prior: float = 8, total_variation: float = 0, views_per_step: int = 0, warm_up: int = 0, freeze: int = 0,
                 error_target: float = 0, mask: Masks | None = None, target_exposure: float = 0, width: int = 0, height: int = 0,
                 max_depth: int = 0, sampling: str = "auto", pixel_sampling: str = "adjoint", roulette: str = "adjoint", positivize: bool = False, no_nee: bool = False, memory: int = 1024,
                 guide_memory: int = 64, sampler: str = "sobol", load_guide: Path | None = None,
                 keep_guide: bool = False, expert: Mapping[str, float] | None = None) -> None:
        paths = path_options(max_depth, sampling, pixel_sampling, roulette, positivize, no_nee, memory, guide_memory, sampler, load_guide, keep_guide, expert)
        options = _options(steps, spp, spp_gradient, spp_difference, seed, loss, optimizer, rate, schedule, final_rate, prior, total_variation, views_per_step,
                           warm_up, freeze, error_target)
        self._shared: Scene | None = None
        self._handle = _cmpg.Recovery((device or scene.device)._handle, scene._handle, targets_of(target, mask, target_exposure, width, height), names_of(param), paths, options)
        self._infos = {info.name: info for info in self._handle.parameters()}

    @classmethod
    def of(cls, renderer: Renderer, target: Targets, *, steps: int = 200, spp: int = 16, spp_gradient: int = 4, spp_difference: int = 12, seed: int = 0,
           loss: str = "mse", optimizer: str = "auto", rate: float | Mapping[str, float] | None = None, schedule: str = "constant", final_rate: float = 0.1,
           prior: float = 8, total_variation: float = 0, views_per_step: int = 0, warm_up: int = 0, freeze: int = 0, error_target: float = 0,
           mask: Masks | None = None, target_exposure: float = 0, width: int = 0, height: int = 0, progress: RecoveryProgress | None = None) -> Recovery:
        """A recovery of a renderer that was made with `recoveries`, and goes on being usable.

        It recovers the renderer's parameters, from the current values of its scene on. Each step takes over what was set in the scene since, and puts its own
        values there. Steps learn the renderer's guide, and draw as the renderer was made to. Passes of the renderer between two steps draw from that
        guide, and nothing is learned from them.

        A renderer has one recovery at a time. Another one ends it, and so do Renderer.set_sampling(), Renderer.forget() and new values of parameters that the
        renderer does not differentiate, or another size of one that it does.

        Args:
            progress: goes on after the steps of another recovery: its progress(). Parameters that were not among its own begin here,
                and so do all where the loss or the targets are others.
            The others as in Recovery.

        Raises:
            UsageError: a renderer that was made without `recoveries`, or options that make no sense.
            InputError: a target that cannot be read or does not fit.
        """
        options = _options(steps, spp, spp_gradient, spp_difference, seed, loss, optimizer, rate, schedule, final_rate, prior, total_variation, views_per_step,
                           warm_up, freeze, error_target)
        recovery = cls.__new__(cls)
        recovery._shared = renderer._scene
        recovery._handle = _cmpg.Recovery(renderer._handle, targets_of(target, mask, target_exposure, width, height), options, progress)
        recovery._infos = {info.name: info for info in recovery._handle.parameters()}
        return recovery

    @property
    def ended(self) -> bool:
        """Whether its renderer was put to another use: steps, images and checkpoints raise UsageError then, all else can be asked for."""
        return self._handle.ended()

    def progress(self) -> RecoveryProgress:
        """What another recovery can go on from: the steps done, and what the optimiser knows of each parameter."""
        return self._handle.progress()

    def on_submission(self, call: Callable[[], None] | None, *, seconds: float = 0.2) -> None:
        """As Renderer.on_submission(), and of its renderer where it has one. A step that `call` ends has changed nothing and can be done again."""
        self._on_submission = call
        self._handle.on_submission(None if call is None else weakly(self, "_on_submission"), seconds)

    def on_image(self, call: Callable[[int, Image], None] | None) -> None:
        """Has `call` called with the number of a target and each image that a step compares with it, from the thread of the step; None: nothing."""
        self._on_image = None if call is None else lambda target, image: call(target, as_image(image))
        self._handle.on_image(None if call is None else weakly(self, "_on_image"))

    def set_samples(self, spp: int, spp_gradient: int) -> None:
        """Samples per pixel of the images and of the derivative passes of the steps to come. Checkpoints do not have them: set them again after
        resume().

        Raises:
            UsageError: one of them is out of range.
        """
        made(self._handle.set_samples, spp=spp, spp_gradient=spp_gradient)

    def set_rate_factor(self, factor: float) -> None:
        """A factor on all rates of the steps to come, from 0 to 1e6, beside the schedule. Checkpoints do not have it: set it again after resume().

        Raises:
            UsageError: it is out of range.
        """
        self._handle.set_rate_factor(factor)

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
            UsageError: the recovery has ended.
        """
        try:
            return self._handle.step()
        finally:
            self._followed()

    def _followed(self) -> None:
        """The scene of a renderer has the values of the last step."""
        if self._shared is not None:
            self._shared._note(self._infos)

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
        """The current values of a parameter, in the shape that it has now: a copy."""
        return as_image(self._handle.values(self._info(name).name))

    def gradient(self, name: str) -> Image:
        """Of the last step, regulariser included, in the shape with which the recovery began: another one ends it. Zeros before the first step."""
        return as_image(self._handle.gradient(self._info(name)))

    @property
    def history(self) -> list[RecoveryStep]:
        """What the steps done have found, those before resume() included: without warnings."""
        return self._handle.history()

    @property
    def report(self) -> PassReport:
        """What all passes so far cost and left out, and how directions are drawn now."""
        return self._handle.report()

    def image(self, target: int = 0, spp: int = 64, initial: bool = False) -> Image:
        """What the camera of a target (by its number) sees at the current values, or at those where the recovery began, (height, width, 3)."""
        return as_image(made(self._handle.image, target=target, spp=spp, initial=initial))

    def image_into(self, film: Film, target: int = 0, spp: int = 64) -> PassReport:
        """Adds `spp` samples per pixel of that image, at the current values, to a film of the target's size. Returns what the pass did.

        Raises:
            UsageError: there is no such target, the film has another size, or the recovery has ended.
        """
        return made(self._handle.image_into, film=film._handle, target=target, spp=spp)

    def target(self, target: int = 0) -> Image:
        """What steps compare with: the image that was given, (height, width, 3)."""
        return as_image(made(self._handle.target, target=target))

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
        scene._note(self._infos)

    def save(self, folder: Path, note: str = "") -> None:
        """Writes all that resume() needs, and keeps the one before. `note` is a text of the caller's, kept with it.

        Raises:
            OutputError: that fails.
        """
        self._handle.save(folder, note)

    @staticmethod
    def note(folder: Path) -> str | None:
        """The note of what resume() continues from; None where the folder has nothing of the kind.

        Raises:
            InputError: nothing of it can be read.
        """
        return _cmpg.Recovery.note(folder)

    def resume(self, folder: Path) -> bool:
        """Continues from what save() wrote to what the saved recovery would have found, bit for bit on the same device.

        Returns:
            False where the folder has nothing of the kind.

        Raises:
            UsageError: it is of a recovery with other options; the first difference is named.
            InputError: it is of another scene or target, or cannot be read.
        """
        try:
            return self._handle.resume(folder)
        finally:
            self._followed()


def loss_of(image: npt.ArrayLike, target: Picture, loss: str = "mse", *, mask: npt.ArrayLike | Path | None = None,
            target_exposure: float = 0) -> tuple[float, Image]:
    """The loss of an image as it is, with its noise, and its derivative by every value of the image, in the image's shape: what Renderer.backward() takes.

    Args:
        image: (height, width, 3).
        target: an array of the same shape, or a file. Values that are not finite have no weight.
        loss: "mse", "l1", "smape" or "relative-mse".
        mask, target_exposure: as in Recovery.

    Raises:
        UsageError: values of the image are not finite.
        InputError: the sizes differ, or no pixel has a weight.
    """
    given = floats(image)
    if not np.isfinite(given).all():
        raise UsageError("the image has values that are not finite", "they would be left out, as if they were right", "look where they come from, or set them to those of the target")
    value, adjoint = _cmpg.loss_of(loss, given, target_of(target, "", mask, target_exposure))
    return value, as_image(adjoint)


def _options(steps: int, spp: int, spp_gradient: int, spp_difference: int, seed: int, loss: str, optimizer: str,
             rate: float | Mapping[str, float] | None, schedule: str, final_rate: float, prior: float, total_variation: float, views_per_step: int,
             warm_up: int, freeze: int, error_target: float) -> _cmpg.RecoveryOptions:
    rates = [] if rate is None else list(rate.items()) if isinstance(rate, Mapping) else [("", float(rate))]
    options: _cmpg.RecoveryOptions = made(
        _cmpg.RecoveryOptions, steps=steps, spp=spp, spp_gradient=spp_gradient, spp_difference=spp_difference, seed=seed, loss=loss, optimizer=optimizer,
        rates=rates, schedule=schedule, final_rate=final_rate, prior=prior, total_variation=total_variation, views_per_step=views_per_step, warm_up=warm_up,
        freeze=freeze, error_target=error_target)
    return options


def targets_of(target: Any, mask: Any, exposure: float, width: int, height: int) -> list[_cmpg.Target]:
    targets: list[_cmpg.Target] = []
    views = target if isinstance(target, Mapping) else {"": target}
    masks = mask if isinstance(mask, Mapping) else dict.fromkeys(views, mask)
    for camera in masks:
        if camera not in views:
            cause = "" if isinstance(target, Mapping) else "the target is given without its camera"
            raise UsageError(f"there is a mask of {camera}, but no target", cause, "name cameras as the targets do", ["target", "mask"])
    for camera, image in views.items():
        held = sum(known.nbytes for known in targets)
        name, moved = view_of(camera)
        whole = target_of(image, name, masks.get(camera), exposure, held >= MOST_TARGET_BYTES)
        targets.append(made(whole.averaged, width=width, height=height) if width or height else whole)
        if moved is not None:
            targets[-1].move(moved)
    return targets


def target_of(image: Any, camera: str, mask: Any, exposure: float, stream: bool = False) -> Any:
    if isinstance(image, (str, os.PathLike)):
        if mask is not None and not isinstance(mask, (str, os.PathLike)):
            raise UsageError("a target that is a file takes a mask that is a file", "", "load the target: cmpg.load_image(file)", ["mask"])
        load = _cmpg.Target.stream if stream else _cmpg.Target.load
        return load(image, camera, "" if mask is None else mask, exposure)
    if str(getattr(image, "dtype", "")).endswith(("uint8", "uint16")):
        raise UsageError("a target of whole numbers holds the codes of a picture, not light", "", "give the file, cmpg.load_image(file), or linear floats")
    if isinstance(mask, (str, os.PathLike)):
        mask = load_image(mask).mean(axis=2)
    pixels, weights = floats(image), None if mask is None else floats(mask)
    if weights is not None and weights.shape not in (pixels.shape[:2], (*pixels.shape[:2], 1)):
        raise UsageError(f"the mask has the shape {weights.shape}, not {pixels.shape[:2]}", "", "give one weight per pixel of the target", ["mask"])
    return _cmpg.Target(pixels * np.float32(2.0**exposure), camera, weights)
