"""Images and their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Names, Path, as_image, floats, made, names_of
from ._callbacks import weakly
from ._cmpg import PassReport
from ._errors import UsageError
from ._film import Film
from ._guide import GuidePoint
from ._scene import Camera, Device, Scene, view_of


def path_options(max_depth: int, sampling: str, pixel_sampling: str, roulette: str, positivize: bool, no_nee: bool, memory: int, guide_memory: int,
                 sampler: str, load_guide: Path | None, keep_guide: bool, expert: Mapping[str, float] | None) -> Any:
    return made(_cmpg.PathOptions, max_depth=max_depth, sampling=sampling, pixel_sampling=pixel_sampling, roulette=roulette, positivize=positivize,
                no_nee=no_nee, memory=memory, guide_memory=guide_memory, sampler=sampler, load_guide=load_guide or "",
                keep_guide=keep_guide, expert={name: float(value) for name, value in (expert or {}).items()})


def pass_options(camera: str | Camera, **options: Any) -> Any:
    name, moved = view_of(camera)
    return made(_cmpg.PassOptions, camera=name, moved=moved, **options)


OnImage = Callable[[Image], None]


def _with_image(call: OnImage | None) -> Callable[[npt.NDArray[np.float32]], None] | None:
    return None if call is None else lambda image: call(as_image(image))


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
        roulette: of backward() after learning passes: "adjoint" ends and splits paths by what the guide expects of them, "off" ends them by what
            surfaces scatter alone, as in images.
        positivize: derivative passes in two halves, one for each sign of the derivative.
        no_nee: no light sampling; emitters are only found by chance.
        memory: MiB of device memory for a pass, beside the scene and its parameters.
        guide_memory: MiB of device memory for the guide.
        sampler: random numbers: "sobol" (Owen-scrambled), or "independent".
        load_guide: a file of save_guide(), from which passes draw and learning passes continue.
        keep_guide: to be saved: learn a guide even where no pass would draw from it.
        expert: guide_share (of directions, drawn from the guide), roulette_effort, cell_records, direction_share, forgetting, all_features, as of
            the command line.
        recoveries: there is room for images, learning, derivatives and recoveries in turn (Recovery.of()), so that a guide outlives what comes next. It takes
            more memory.

    Raises:
        UsageError: an unknown parameter or an option out of range.
        DeviceError: memory is short.
    """

    def __init__(self, scene: Scene, param: Names = (), *, device: Device | None = None, max_depth: int = 0, sampling: str = "auto",
                 pixel_sampling: str = "adjoint", roulette: str = "adjoint", positivize: bool = False, no_nee: bool = False, memory: int = 1024,
                 guide_memory: int = 64, sampler: str = "sobol", load_guide: Path | None = None,
                 keep_guide: bool = False, expert: Mapping[str, float] | None = None, recoveries: bool = False) -> None:
        paths = path_options(max_depth, sampling, pixel_sampling, roulette, positivize, no_nee, memory, guide_memory, sampler, load_guide, keep_guide, expert)
        #: what the last pass did: samples, error, seconds, method; None before the first
        self.report: PassReport | None = None
        self._scene = scene
        self._handle = _cmpg.Renderer((device or scene.device)._handle, scene._handle, names_of(param), paths, recoveries)

    @property
    def parameters(self) -> list[str]:
        """Names of what derivatives may be asked for, globs expanded."""
        return [info.name for info in self._handle.parameters()]

    def render(self, *, camera: str | Camera = "", width: int = 0, height: int = 0, spp: int = 0, seed: int = 0, train: int = 0, train_spp: int = 0,
               anew: bool = True, frozen: bool = False, error_target: float = 0, time_budget: float = 0, batches: int = 0, layers: bool = False,
               on_image: OnImage | None = None) -> Image:
        """Radiance, (height, width, 3).

        Args:
            camera: its name, or a Camera that may have been moved; "": the first.
            width, height: in pixels; 0: from the other one by the camera's aspect ratio; both 0: a Mitsuba film's size, else 512 wide.
            spp: samples per pixel; 0: 64, or up to 65536 under an error target or a time budget.
            seed: equal seeds, equal random numbers; images and derivatives of one seed have independent ones.
            train: learning passes before this one. They learn a guide, from which this pass and those after it draw.
            train_spp: samples per pixel of each; 0: all together as many as the pass, but 4 each.
            anew: whether they forget what passes of this renderer have learned before.
            frozen: draws from no guide.
            error_target: sample until |standard error| / |image| is this small (0.01 is 1 %); `spp` is the most. 0: no target.
            time_budget: sample for so many seconds, learning included; 0: no budget.
            batches: divide the samples among so many batches, whose spread tells the error in `report`; 0: 8 with a target or budget, else none.
            layers: `report.layers()` then has what the camera sees first and what the guide does there: "normal" (height, width, 3), "depth", "albedo" ...
            on_image: called with the image as it grows, now and then; the result is the same. What it raises ends the pass.

        Raises:
            UsageError: an unknown camera, or an option out of range.
        """
        image, self.report = self._handle.render(
            pass_options(camera, width=width, height=height, spp=spp, seed=seed, train=train, train_spp=train_spp, anew=anew, frozen=frozen,
                         error_target=error_target, time_budget=time_budget, batches=batches, layers=layers),
            _with_image(on_image))
        return as_image(image)

    def forward(self, direction: Mapping[str, npt.ArrayLike], *, camera: str | Camera = "", width: int = 0, height: int = 0, spp: int = 0, seed: int = 0,
                train: int = 0, train_spp: int = 0, anew: bool = True, frozen: bool = False, error_target: float = 0, time_budget: float = 0,
                batches: int = 0, layers: bool = False, on_image: OnImage | None = None) -> Image:
        """The derivative of the image along a direction, (height, width, 3): the sum over the parameters of dI/dp . v.

        Args:
            direction: v by the name of the parameter: an array of its shape, one value per channel, or a number.
            frozen: with the random numbers of render() with the same seed, for comparison with finite differences; from no guide.
            The others as in render().
        """
        image, self.report = self._handle.forward(
            self._directions(direction),
            pass_options(camera, width=width, height=height, spp=spp, seed=seed, train=train, train_spp=train_spp, anew=anew, frozen=frozen,
                         error_target=error_target, time_budget=time_budget, batches=batches, layers=layers),
            _with_image(on_image))
        return as_image(image)

    def render_into(self, film: Film, *, camera: str | Camera = "", spp: int = 64, seed: int = 0) -> None:
        """Adds samples to a film: those that follow the film's in the sequence of the seed's random numbers.

        For passes of one film, all else is equal: values, camera and seed. Directions are drawn by what was found best so far, and nothing is learned from
        the samples. A pass that Ctrl-C ends leaves the film as it was.

        Args:
            film: the image has its size.
            camera, seed: as in render().
            spp: samples per pixel that are added.

        Raises:
            UsageError: an unknown camera, or an option out of range.
        """
        self.report = self._handle.render_into(film._handle, pass_options(camera, spp=spp, seed=seed))

    def forward_into(self, film: Film, direction: Mapping[str, npt.ArrayLike], *, camera: str | Camera = "", spp: int = 64, seed: int = 0) -> None:
        """The same for the derivative of the image along a direction, as in forward()."""
        self.report = self._handle.forward_into(film._handle, self._directions(direction), pass_options(camera, spp=spp, seed=seed))

    def train(self, direction: Mapping[str, npt.ArrayLike] | None = None, *, passes: int = 1, spp: int = 64, camera: str | Camera = "", width: int = 0,
              height: int = 0, seed: int = 0) -> None:
        """Learning passes alone: they go on from all that this method has learned so far, with random numbers of their own.

        Args:
            direction: learn for derivatives along it, as in forward(); None: for images.
            passes: how many.
            spp: samples per pixel of each.
            camera, width, height, seed: as in render().

        Raises:
            UsageError: an unknown camera, or an option out of range.
        """
        try:
            options = pass_options(camera, width=width, height=height, spp=spp, seed=seed, train=passes)
            self._handle.train(self._directions(direction or {}), options)
        except UsageError as error:
            if error.options != ["train"]:
                raise
            raise UsageError(error.what.replace("train", "passes", 1), error.cause, error.remedy, ["passes"]) from None

    def on_submission(self, call: Callable[[], None] | None, *, seconds: float = 0.2) -> None:
        """Has `call` called from the thread of a pass, before every submission to the device; None: nothing.

        Results do not depend on it. What it raises ends the pass, and nothing of it remains.

        Args:
            seconds: about what one submission takes, from 0.001 to 10.
        """
        self._on_submission = call
        self._handle.on_submission(None if call is None else weakly(self, "_on_submission"), seconds)

    def forget(self) -> None:
        """Forgets all that the guide has learned."""
        self._handle.forget()

    def set_sampling(self, sampling: str) -> None:
        """Has directions drawn otherwise from here on, by the guide as it is. It takes a renderer with `recoveries`, and ends its recovery.

        Raises:
            UsageError: there is no such method, or the renderer was made without `recoveries`.
        """
        self._handle.set_sampling(sampling)

    def footprint(self, kinds: str | Sequence[str] = "render", *, train: bool = False) -> dict[str, Any]:
        """What a renderer with these options would take. Its buffers are allocated beside those of this one and freed again, nothing is compiled.

        Args:
            kinds: of passes: "render", "forward", "backward", or several.
            train: with learning passes before them.

        Returns:
            "buffers": bytes of device memory, by what is in them;
            "kernels": a dict each: "kind" of the passes that it is for, "name", and "bytes" and "module_bytes" of SPIR-V: specialised for the scene, and as it is
            for all scenes;
            "features": what kernels are made for, by name: "on", "off" or what it is.

        Raises:
            UsageError: there is no such kind.
            DeviceError: memory is short.
        """
        return self._handle.footprint(names_of(kinds), pass_options("", train=int(train)))

    def guide_at(self, position: Sequence[float], kind: str = "render") -> GuidePoint | None:
        """What the guide knows at a point of the scene; None where it has learned nothing yet.

        Args:
            position: (x, y, z), such as the position of a SurfacePoint.
            kind: of the passes that draw: "render", "forward" or "backward".
        """
        found = self._handle.guide_at([float(x) for x in position], kind)
        return None if found is None else GuidePoint(found)

    def guide_cells(self, depth: npt.ArrayLike, *, camera: str | Camera = "") -> Image | None:
        """The number of the guide's cell at the first surface of every pixel, (height, width, 1); -1 where there is none.

        Args:
            depth: (height, width, 1): "depth" of the layers of a pass or film by that camera.

        Returns:
            None where the guide has learned nothing yet.
        """
        cells = self._handle.guide_cells(floats(depth), pass_options(camera))
        return None if cells is None else as_image(cells)

    def _directions(self, direction: Mapping[str, npt.ArrayLike]) -> list[tuple[str, npt.NDArray[np.float32]]]:
        if not isinstance(direction, Mapping):
            raise UsageError(f"a direction is a mapping, not {direction!r}", "", "give values by parameter, as {name: 1}", ["direction"])
        return [(name, self._direction(name, values)) for name, values in direction.items()]

    def _direction(self, name: str, values: npt.ArrayLike) -> npt.NDArray[np.float32]:
        given, shape = floats(values), self._scene[name].shape
        if not np.isfinite(given).all():
            raise UsageError(f"the direction of {name} has values that are not finite", "", "give finite ones")
        try:
            return floats(np.broadcast_to(given, shape))
        except ValueError:
            raise UsageError(f"the direction of {name} has the shape {given.shape}, not {shape}", "", "give that shape, one value per channel, or a number") from None

    def check(self, name: str, direction: npt.ArrayLike = 1, *, camera: str | Camera = "", width: int = 0, height: int = 0, spp: int = 16, spp_gradient: int = 0,
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
        options = pass_options(camera, width=width, height=height, spp=spp, seed=seed, frozen=True)
        return made(self._handle.check, parameter=name, direction=self._direction(name, direction), options=options, spp_gradient=spp_gradient)

    def save_guide(self, file: Path) -> None:
        """Writes what was learned, for `load_guide`.

        Raises:
            UsageError: nothing was learned.
            OutputError: it cannot be written.
        """
        self._handle.save_guide(file)

    def backward(self, adjoint: npt.ArrayLike, *, camera: str | Camera = "", spp: int = 0, seed: int = 0, train: int = 0, train_spp: int = 0,
                 anew: bool = True, frozen: bool = False, error_target: float = 0, time_budget: float = 0, batches: int = 0) -> dict[str, Image]:
        """adjoint^T . dI/dp of every parameter in `param`, by name, in the parameter's shape.

        Args:
            adjoint: (height, width, 3): the derivative of a scalar by every pixel. The pass has its size.
            frozen: with the random numbers of render() with the same seed, equally many samples in every pixel and no guide, for comparison with
                finite differences. In an optimisation their noise would be correlated with the image's.
            The others as in render().
        """
        gradients, self.report = self._handle.backward(
            floats(adjoint), pass_options(camera, spp=spp, seed=seed, train=train, train_spp=train_spp, anew=anew, frozen=frozen, error_target=error_target,
                                          time_budget=time_budget, batches=batches))
        return {name: as_image(gradient) for name, gradient in gradients.items()}
