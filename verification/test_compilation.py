"""Kernels are compiled once, by several processes, and whatever becomes of those beside."""

import os
import pickle
import select
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from numba import types
from numba.core.registry import CPUDispatcher as Dispatcher

from corovec import Settings, simulate, warm_up
from corovec.solver import compilation, kernels
from corovec.solver.kernels import assembly, nodes, observation, transport, updates
from corovec.solver.system.system import System
from corovec.verification.models import rectangle, spinning


@pytest.mark.slow
@pytest.mark.parametrize("kind", compilation.ASSEMBLING)
def test_a_process_beside_compiles_the_kernel_that_assembles(kind):
    """Its command ends well and tells a folder with the kernel's index and code."""
    warm_up(exact=True)
    run = subprocess.run([sys.executable, "-c",
                          "from corovec.solver.compilation import compile_assembly; "
                          f"compile_assembly({kind.__name__!r})"],
                         capture_output=True, text=True, check=True)
    endings = {path.suffix for path in Path(run.stdout.strip()).glob(compilation._files_of(kind))}
    assert endings == {".nbi", ".nbc"}


def test_its_files_are_moved(tmp_path, monkeypatch):
    """What it compiled is in the common folder afterwards, its own cache is gone."""
    commands = []
    (tmp_path / "beside-System-of-a-killed-one").mkdir()

    class Process(subprocess.Popen):
        def __init__(self, command, env, **options):
            commands.append(command)
            own = Path(env["NUMBA_CACHE_DIR"], "kernels")
            own.mkdir()
            for name in ("assembly.step_system-1.nbi", "assembly.step_system-1.1.nbc", "other.nbi"):
                (own / name).write_text(name)
            super().__init__([sys.executable, "-c", f"print({str(own)!r})"], env=env, **options)

    monkeypatch.setattr(subprocess, "Popen", Process)
    with compilation._assembly_beside(tmp_path, System):
        pass
    assert "compile_assembly" in commands[0][-1]
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "assembly.step_system-1.1.nbc", "assembly.step_system-1.nbi"]


def test_a_second_process_that_fails_loses_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", "false")
    with compilation._assembly_beside(tmp_path, System):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_second_process_ends_with_the_first(tmp_path):
    """Killed while both compile, and interrupted: the second one is gone as well."""
    code = ("import os, signal, subprocess; from pathlib import Path\n"
            "from corovec.solver import compilation; popen = subprocess.Popen\n"
            "subprocess.Popen = lambda *command, stderr, **options: popen(*command, **options)\n"
            f"with compilation._assembly_beside(Path({str(tmp_path)!r}), compilation.System):\n"
            "    os.kill(os.getpid(), signal.SIGKILL)")
    # the pipe ends when the last process that can write to it has ended
    ended = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, timeout=20.0)
    assert ended.returncode == -signal.SIGKILL
    left = [path for path in tmp_path.iterdir() if path.name.startswith(compilation.BESIDE)]
    with pytest.raises(KeyboardInterrupt), compilation._assembly_beside(tmp_path, System):
        assert left and not any(path.exists() for path in left)
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_models_of_other_processes_need_the_same_kernels():
    """Seen: studies and ``run_many`` compiled all of them a second time, for writable arrays."""
    warm_up()
    compiled = len(assembly.step_system.signatures)
    plate = pickle.loads(pickle.dumps(spinning(rectangle(2.0, 1.0, (2, 1)), (0.0, 0.0, 1.0))))
    simulate(plate, Settings(dt=0.01, end_time=0.02))
    assert len(assembly.step_system.signatures) == compiled


def test_compiled_kernels_need_no_second_process(monkeypatch):
    warm_up()
    monkeypatch.setattr(compilation, "_assembly_beside", None)
    warm_up()


def test_one_process_compiles_at_a_time(tmp_path):
    """A second one waits, and says so, until the first has left."""
    code = ("from pathlib import Path; from corovec.solver import compilation\n"
            f"with compilation._one_at_a_time(Path({str(tmp_path)!r})):\n"
            "    print('here', flush=True)\n"
            "    input()")

    def begin():
        return subprocess.Popen([sys.executable, "-c", code], text=True, stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    with begin() as first:
        assert first.stdout.readline() == "here\n"
        with begin() as second:
            spoken = select.select([second.stdout, second.stderr], [], [], 60.0)[0]
            assert spoken == [second.stderr]
            assert "waiting for another process" in second.stderr.readline()
            first.communicate("leave\n", timeout=60.0)
            assert second.communicate("leave\n", timeout=60.0)[0] == "here\n"
    assert first.returncode == second.returncode == 0


def test_folders_without_locks(tmp_path, monkeypatch):
    """Where files cannot be locked, nobody waits."""
    def unsupported(*_, **options):
        raise NotImplementedError("no flock here")

    monkeypatch.setattr(compilation.FileLock, "acquire", unsupported)
    with compilation._one_at_a_time(tmp_path):
        assert not (tmp_path / "compiling.lock").exists()


def named_tuples(type_):
    """Classes of all named tuples in a type of numba."""
    if isinstance(type_, types.BaseNamedTuple):
        yield type_.instance_class
    if isinstance(type_, types.BaseTuple):
        for inner in type_:
            yield from named_tuples(inner)


def test_the_cache_sees_the_fields_of_all_arguments(tmp_path, monkeypatch):
    """A field is a position in compiled code: two that change places make another cache folder, and
    every named tuple that a kernel takes is defined among the sources that name the folder."""
    warm_up()
    found = {cls for module in (assembly, nodes, observation, transport, updates)
             for kernel in vars(module).values() if isinstance(kernel, Dispatcher)
             for signature in kernel.signatures for type_ in signature
             for cls in named_tuples(type_)}
    assert {"Elements", "Motion", "Factors"} <= {cls.__name__ for cls in found}
    assert all(cls.__module__.startswith(f"{kernels.__name__}.") for cls in found)
    copy = shutil.copytree(Path(kernels.__file__).parent, tmp_path / "kernels")
    monkeypatch.setattr(kernels, "__file__", str(copy / "__init__.py"))
    before = kernels.cache_folder()
    text = (copy / "arguments.py").read_text(encoding="utf-8")
    one, other = "    y0: np.ndarray\n", "    r0: np.ndarray\n"
    assert one + other in text
    (copy / "arguments.py").write_text(text.replace(one + other, other + one), encoding="utf-8")
    assert kernels.cache_folder() != before


def test_first_kernels_say_that_they_compile(tmp_path):
    """Once, by a process that finds no compiled kernel."""
    code = ("import numpy; from corovec.solver.system import system; "
            "from corovec.solver.kernels import vectors; "
            "vectors.cross(*numpy.zeros((3, 3))); vectors.dot(*numpy.zeros((2, 3)))")
    for times in (1, 0):
        told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              check=True, env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)})
        assert told.stderr.count("compiling the kernels") == times
