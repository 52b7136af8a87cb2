"""Passes shared by the ranks of an mpi4py communicator."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np

from ._errors import DeviceError, UsageError

_MOST = 1 << 26  # bytes of one call, which bounds the copies
_PATIENCE = 0.002  # seconds of waiting at full speed
_FAILED = 1  # tag of the message that a rank has left a pass
_abandoned: list[Any] = []  # requests that never end, with their buffers: MPI may still write there

# What launchers tell the processes that they start: how many there are.
_LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")


class Ranks:
    """What a device asks of its communicator.

    Calls do not block but poll, so that Ctrl-C works, and a rank that fails ends the passes of all. They work on copies: one that is given up may still be
    written to.
    """

    def __init__(self, communicator: Any) -> None:
        try:
            from mpi4py import MPI
        except ImportError as error:
            raise DeviceError("mpi4py cannot be loaded", str(error), "pip install mpi4py, and an MPI: Debian's packages are libopenmpi3 and libmpich12",
                              ["communicator"]) from error
        if not isinstance(communicator, MPI.Comm):
            raise UsageError(f"{type(communicator).__name__} is no communicator", "", "give one of mpi4py, such as MPI.COMM_WORLD", ["communicator"])
        if communicator == MPI.COMM_NULL or MPI.Is_finalized():
            raise UsageError("the communicator does not exist", "it was freed, it excludes this process, or MPI has ended", "give one that does", ["communicator"])
        if communicator.Is_inter():
            raise UsageError("passes are not shared by two groups", "this communicator connects two", "give that of a group, or communicator.Merge()", ["communicator"])
        started = max(int(os.environ.get(name, "1")) for name in _LAUNCHERS)
        if MPI.COMM_WORLD.Get_size() == 1 and started > 1:
            raise DeviceError(f"mpirun started {started} processes, of which mpi4py's MPI sees one",
                              f"mpi4py has loaded {MPI.Get_library_version().splitlines()[0].strip()}, and mpirun is of another MPI",
                              "take that MPI's mpirun, or have mpi4py load another one by MPI4PY_MPIABI", ["communicator"])
        self._mpi = MPI
        self._all = communicator.Dup()  # never freed: that takes all ranks at once, and they drop a device when each likes
        self._failure = ""
        machine = self._all.Split_type(MPI.COMM_TYPE_SHARED)
        self.rank, self.size = self._all.Get_rank(), self._all.Get_size()
        self.local_rank, self.local_size = machine.Get_rank(), machine.Get_size()
        machine.Free()

    def sum(self, values: memoryview) -> None:
        whole = np.frombuffer(values, np.uint64)  # unsigned: sums are modulo 2^64
        for part in np.array_split(whole, -(-whole.nbytes // _MOST) or 1):
            copy = part.copy()
            self._wait(lambda: self._all.Iallreduce(self._mpi.IN_PLACE, [copy, self._mpi.UINT64_T]))
            part[:] = copy

    def broadcast(self, values: memoryview, root: int) -> None:
        whole = np.frombuffer(values, np.uint8)
        for part in np.array_split(whole, -(-whole.nbytes // _MOST) or 1):
            copy = part.copy()
            self._wait(lambda: self._all.Ibcast([copy, self._mpi.BYTE], root))
            part[:] = copy

    def gather(self, own: memoryview, sizes: list[int], values: memoryview) -> None:
        whole = np.frombuffer(values, np.uint8)
        begin = np.concatenate([[0], np.cumsum(sizes)])
        if whole.nbytes > _MOST:
            mine = whole[begin[self.rank]:begin[self.rank + 1]]
            mine[:] = np.frombuffer(own, np.uint8)
            for rank in range(self.size):
                self.broadcast(whole[begin[rank]:begin[rank + 1]].data, rank)
            return
        sent, received = np.array(np.frombuffer(own, np.uint8)), np.empty(whole.size, np.uint8)
        self._wait(lambda: self._all.Iallgatherv([sent, self._mpi.BYTE], [received, (sizes, begin[:-1].tolist()), self._mpi.BYTE]))
        whole[:] = received

    def fail(self, why: str) -> None:
        """This rank has left a pass that others may be waiting in."""
        if self._failure:
            return
        self._failure = f"rank {self.rank} of {self.size} failed: {why}"
        text = np.frombuffer(why.encode(errors="replace")[:4000], np.uint8)
        for rank in range(self.size):
            if rank != self.rank:
                _abandoned.append(self._all.Isend([text, self._mpi.BYTE], rank, _FAILED))

    def _wait(self, begin: Any) -> None:
        if self._failure:
            raise DeviceError("the ranks of this device no longer work together", self._failure, "open a device anew on all of them", ["communicator"])
        request = None
        started = time.monotonic()
        try:
            request = begin()
            while not request.Test():
                if time.monotonic() - started < _PATIENCE:
                    os.sched_yield()  # ranks that share a processor
                    continue
                self._look_for_failures()
                time.sleep(5e-5)
        except BaseException as error:  # here rather than in the pass: what others send next would be taken for what this call waits for
            _abandoned.append(request)
            self.fail(f"{type(error).__name__}: {error}".removesuffix(": "))
            raise

    def _look_for_failures(self) -> None:
        status = self._mpi.Status()
        if not self._all.Iprobe(self._mpi.ANY_SOURCE, _FAILED, status):
            return
        text = np.empty(status.Get_count(self._mpi.BYTE), np.uint8)
        self._all.Recv([text, self._mpi.BYTE], status.Get_source(), _FAILED)
        self._failure = f"rank {status.Get_source()} of {self.size} failed: {text.tobytes().decode(errors='replace')}"
        raise DeviceError(self._failure, "", "see to its cause, and open a device anew on all ranks", ["communicator"])
