#!/usr/bin/env python3
"""The Python package on several ranks of mpi4py.

usage: python_ranks_test.py SCENARIO SOURCE MPIRUN OTHER_MPIRUN     (PYTHONPATH has the package)

same      images, derivatives and recoveries are the same bytes from a process alone and from 1, 2 and 3 ranks, on all ranks, and a recovery goes on from
          the checkpoint of one rank less as from its own
failed    a rank that leaves a pass ends that of the others, and new devices work
refused   communicators that are none, ranks that ask for different things, processes of another MPI's mpirun

With a folder in place of MPIRUN it is what the ranks run.
"""
import hashlib
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings

scenario, source, launcher, other = sys.argv[1:5]
box, painting, light = f"{source}/scenes/box/scene.gltf", "painting.baseColor", "light.emission"


def launch(mpirun, ranks, folder):
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "LP_NUM_THREADS": "1"}
    own = [sys.executable, __file__, scenario, source, str(folder), str(ranks)]
    if ranks == 0:  # alone, without mpi4py
        return subprocess.run(own, env=environment, capture_output=True, text=True, timeout=300)
    if "mpich" in launcher:  # wheels of mpi4py look for MPICH by the name of its ABI, which Debian's library lacks
        library = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, env={"PATH": "/usr/sbin:/sbin"}).stdout
        found = [line.split("=> ")[1] for line in library.splitlines() if "libmpich.so.12 " in line and "=> " in line]
        link = folder / "libmpi.so.12"
        if found and not link.exists():
            link.symlink_to(found[0])
        environment.update(MPI4PY_MPIABI="mpich", LD_LIBRARY_PATH=str(folder))
    if subprocess.run([sys.executable, "-c", "from mpi4py import MPI"], env=environment, capture_output=True).returncode != 0:
        print("mpi4py is not installed or does not find this MPI: scripts/python-env installs it")
        sys.exit(77)
    start = [mpirun, "-n", str(ranks)] + ([] if "mpich" in mpirun else ["--oversubscribe", "--bind-to", "none"])
    return subprocess.run(start + own, env=environment, capture_output=True, text=True, timeout=300)


def expect(done, *texts, fails=False):
    if (done.returncode != 0) != fails:
        sys.exit(f"exit code {done.returncode}:\n{done.stdout}{done.stderr}")
    for text in texts:
        if text not in done.stdout + done.stderr:
            sys.exit(f"no '{text}', exit code {done.returncode}:\n{done.stdout}{done.stderr}")


def main():
    with tempfile.TemporaryDirectory(prefix="cmpg-python-ranks-") as name:
        folder = pathlib.Path(name)
        if scenario == "same":
            found = {ranks: launch(launcher, ranks, folder) for ranks in (0, 1, 2, 3)}
            for ranks, done in found.items():
                print(f"{ranks} ranks\n{done.stdout}{done.stderr}", flush=True)
                expect(done, "recovery")
            if any(done.stdout != found[0].stdout for done in found.values()):
                sys.exit("results differ")
        elif scenario == "failed":
            done = launch(launcher, 2, folder)
            expect(done, "rank 0: rank 1 of 2 failed: KeyboardInterrupt", "rank 0: the ranks of this device no longer work together", "rank 1: interrupted",
                   "rank 1: first interrupted", "rank 1: second the ranks of this device no longer work together",
                   "rank 0: first rank 1 of 2 failed: KeyboardInterrupt", "rank 0: second the ranks of this device no longer work together",
                   "rank 0: UsageError a memory budget of 16 MiB does not hold one batch", "rank 1: DeviceError rank 0 of 2 failed: a memory budget",
                   "rank 0: anew True", "rank 1: anew True")
        else:
            done = launch(launcher, 2, folder)
            expect(done, "all refused 0", "all refused 1")
            if os.path.exists(other):
                expect(launch(other, 2, folder), "mpirun started 2 processes, of which mpi4py's MPI sees one", fails=True)
            else:
                print(f"not tried, since the other MPI is not installed: processes of its mpirun ({other})")


def say(text):
    """A line of a rank, in one write: the launcher mixes what its ranks write at the same time."""
    os.write(1, f"{text}\n".encode())


def same(cmpg, communicator, folder, ranks):
    import numpy as np

    device = cmpg.Device(communicator=communicator) if communicator else cmpg.Device()

    def show(name, data):
        digest = hashlib.sha256(data).hexdigest()[:16]
        everywhere = {digest} if communicator is None else set(communicator.allgather(digest))
        assert len(everywhere) == 1, f"{name} differs between the ranks"
        if communicator is None or communicator.rank == 0:
            say(f"{name} {digest}")

    scene = cmpg.Scene(box)
    target = cmpg.Renderer(scene, device=device, max_depth=4).render(width=48, height=40, spp=4, seed=7)
    show("image", target.tobytes())
    scene[painting] = 0.5
    renderer = cmpg.Renderer(scene, [painting, light], device=device, max_depth=4, keep_guide=True)
    image = renderer.render(width=48, height=40, spp=4, train=2)
    show("guided image", image.tobytes())
    renderer.save_guide(f"{folder}/{ranks}.guide")
    if communicator:
        communicator.Barrier()
    show("guide", pathlib.Path(f"{folder}/{ranks}.guide").read_bytes())
    show("forward", renderer.forward({light: 1}, width=48, height=40, spp=4).tobytes())
    gradients = renderer.backward(image - target, spp=64)
    show("backward", b"".join(g.tobytes() for g in gradients.values()))
    show("to an error", renderer.render(width=24, error_target=0.2).tobytes() + np.float64(renderer.report.error).tobytes())
    recovery = cmpg.Recovery(scene, target, [painting, light], device=device, steps=3, spp=4, max_depth=4)
    steps = [(s.loss, s.loss_error, s.gradient_norm) for s in recovery]
    recovery.save(f"{folder}/{ranks}")
    if communicator:
        communicator.Barrier()
    show("recovery", repr(steps).encode() + recovery[painting].tobytes() + recovery[light].tobytes() + recovery.image().tobytes())
    other = cmpg.Recovery(scene, target, [painting, light], device=device, steps=3, spp=4, max_depth=4)
    other.resume(f"{folder}/{ranks}" if ranks == 0 else f"{folder}/{ranks - 1}")  # of one rank less
    for went_on in (False, True):
        if went_on:
            a, b = recovery.step(), other.step()
            assert (a.loss, a.loss_error, a.gradient_norm) == (b.loss, b.loss_error, b.gradient_norm), "it goes on in another way"
        for name in (painting, light):
            assert (other[name] == recovery[name]).all(), f"{name} differs, {'after a step' if went_on else 'as it was read'}"


def failed(cmpg, communicator, folder, ranks):
    rank = communicator.rank
    renderer = cmpg.Renderer(cmpg.Scene(box), device=cmpg.Device(communicator=communicator))
    before = renderer.render(width=32, spp=1)
    if rank == 1:
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        renderer.render(width=512, spp=16)
        say(f"rank {rank}: done")
    except KeyboardInterrupt:
        say(f"rank {rank}: interrupted")
    except cmpg.DeviceError as error:
        say(f"rank {rank}: {error}")
    try:
        renderer.render(width=32, spp=1)
    except cmpg.DeviceError as error:
        say(f"rank {rank}: {error}")
    # While it waits for the agreement on a pass, which the other rank has not asked for yet.
    renderer = cmpg.Renderer(cmpg.Scene(box), device=cmpg.Device(communicator=communicator))
    renderer.render(width=32, spp=1)
    if rank == 1:
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    else:
        time.sleep(1.5)
    for attempt in ("first", "second"):  # of which rank 0 would otherwise take the second's for the first's
        try:
            renderer.render(width=32 if attempt == "first" else 48, spp=1)
            say(f"rank {rank}: {attempt} done")
        except KeyboardInterrupt:
            say(f"rank {rank}: {attempt} interrupted")
        except cmpg.Error as error:
            say(f"rank {rank}: {attempt} {error}")
    # Memory is short on one rank alone, which the agreement does not see.
    renderer = cmpg.Renderer(cmpg.Scene(box), device=cmpg.Device(communicator=communicator), max_depth=64, memory=16 + 48 * rank)
    try:
        renderer.render(width=32, spp=1)
    except cmpg.Error as error:
        say(f"rank {rank}: {type(error).__name__} {error}")
    anew = cmpg.Renderer(cmpg.Scene(box), device=cmpg.Device(communicator=communicator)).render(width=32, spp=1)
    say(f"rank {rank}: anew {bool((anew == before).all())}")


def refused(cmpg, communicator, folder, ranks):
    import numpy as np
    from mpi4py import MPI

    rank = communicator.rank

    def refuses(text, call):
        try:
            call()
        except cmpg.UsageError as error:
            assert text in str(error), error
        else:
            raise AssertionError(f"not refused: {text}")

    refuses("is no communicator", lambda: cmpg.Device(communicator=3))
    freed = communicator.Dup()
    freed.Free()
    refuses("does not exist", lambda: cmpg.Device(communicator=freed))
    half = communicator.Split(rank)
    inter = half.Create_intercomm(0, communicator, 1 - rank)
    refuses("two groups", lambda: cmpg.Device(communicator=inter))
    kept = communicator.Dup()
    device = cmpg.Device(communicator=kept)
    kept.Free()  # the device has its own
    scene = cmpg.Scene(box)
    renderer = cmpg.Renderer(scene, painting, device=device)
    image = renderer.render(width=16, spp=1)
    refuses("another pass", lambda: renderer.render(width=16, spp=1, seed=rank))
    refuses("another pass", lambda: renderer.backward(image + rank, spp=1))
    refuses("not finite", lambda: renderer.backward(image + (np.nan if rank else 0), spp=1))  # of the other rank, too
    refuses("time budget", lambda: renderer.render(width=16, time_budget=1))
    refuses("something else", lambda: cmpg.Recovery(scene, image + rank, painting, device=device))
    scene[painting] = 0.25 * rank
    refuses("another pass", lambda: renderer.render(width=16, spp=1))
    scene[painting] = 0.25
    assert (renderer.render(width=16, spp=1) != image).any()  # and goes on
    alone = cmpg.Device(communicator=MPI.COMM_SELF)
    assert (cmpg.Renderer(cmpg.Scene(box), device=alone).render(width=16, spp=1, seed=rank) >= 0).all()
    say(f"all refused {rank}")


if os.path.isdir(launcher):
    import cmpg

    world = None
    if int(other) > 0:
        warnings.filterwarnings("ignore", "suspicious MPI")
        from mpi4py import MPI

        world = MPI.COMM_WORLD
        if scenario == "refused" and world.size == 1:
            cmpg.Device(communicator=world)  # throws
    {"same": same, "failed": failed, "refused": refused}[scenario](cmpg, world, launcher, int(other))
else:
    main()
