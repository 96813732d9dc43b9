"""Commands never use a kernel that was compiled from other sources, nor need a writable folder."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core.caching import CompileResultCacheImpl, FunctionCache

from bench.cli import kernel_cache
from lod import kernels
from scenes.processes import cache as sources

ROOT = Path(__file__).parents[3]
PHILOX = (
    "import numpy as np; from scenes.noise import philox4x64;"
    "print(philox4x64(*np.arange(6, dtype=np.uint64))[0])"
)
WITH_CACHE = f"from bench.cli.kernel_cache import use_kernel_cache; use_kernel_cache(); {PHILOX}"


def installation(folder: Path) -> Path:
    """Copy what the small kernel needs, without caches."""
    for name in ("bench/cli", "scenes/processes", "lod"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in ("bench/__init__.py", "scenes/__init__.py", "scenes/files.py", "scenes/noise.py"):
        shutil.copy(ROOT / name, folder / name)
    return folder


def python(code: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run code in the installation, without what the tests' environment says of the cache."""
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "NUMBA_CACHE_DIR")}
    kept["LODBENCH_CACHE"] = str(folder / "cache")
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, cwd=folder, env=kept | variables, capture_output=True, text=True, check=False
    )


DAMAGES = {
    # As a type's new name leaves an index: the version can be read, the signatures cannot.
    "renamed": ("*.nbi", lambda data: data.replace(b"Integer", b"Removed")),
    "index emptied": ("*.nbi", lambda data: b""),
    "index cut off": ("*.nbi", lambda data: data[: len(data) // 2]),
    "index zeroed": ("*.nbi", lambda data: bytes(len(data))),
    "code emptied": ("*.nbc", lambda data: b""),
    "code cut off": ("*.nbc", lambda data: data[: len(data) // 2]),
    # In the middle of the machine code: Numba would run it.
    "code changed": (
        "*.nbc",
        lambda data: bytes(b ^ (k == data.find(b"ELF") + 900) for k, b in enumerate(data)),
    ),
}


def test_kernels_that_are_damaged_are_compiled_again(tmp_path: Path) -> None:
    folder = installation(tmp_path)
    first = python(WITH_CACHE, folder)
    for name, (files, change) in DAMAGES.items():
        (whole,) = (path for path in (folder / "cache").rglob(f"*philox4x64-{files}"))
        before = whole.read_bytes()
        whole.write_bytes(change(before))
        assert whole.read_bytes() != before, name
        again = python(WITH_CACHE, folder)
        assert (again.stdout, again.stderr) == (first.stdout, ""), name
        assert again.stdout and whole.stat().st_size >= len(before) - 9, "it is kept again"


def test_a_callers_own_kernels_are_kept_as_numba_keeps_them() -> None:
    own, ours = (module.njit(cache=True)(lambda x: x) for module in (numba, kernels))
    assert type(own._cache) is FunctionCache and type(ours._cache) is not FunctionCache
    assert FunctionCache._impl_class is CompileResultCacheImpl


def test_the_digest_changes_with_each_byte_and_name(tmp_path: Path) -> None:
    """A process keeps what it found when it began: here each is another process's."""
    digests = []
    for name, text in (("a.py", "x = 1"), ("a.py", "x = 2"), ("b.py", "x = 2")):
        for old in tmp_path.iterdir():
            old.unlink()
        (tmp_path / name).write_text(text)
        sources._digest.cache_clear()
        digests.append(sources.source_digest([tmp_path]))
    assert len(set(digests)) == 3


@pytest.fixture
def before_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand for a process that has not imported Numba and has no folder named."""
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")  # and what the function sets is undone


@pytest.mark.usefixtures("before_numba")
def test_the_first_writable_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    kernel_cache.use_kernel_cache([tmp_path / "file", tmp_path / "cache"])
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == tmp_path / "cache"


@pytest.mark.usefixtures("before_numba")
def test_without_a_writable_folder_one_line_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    for _ in range(2):
        kernel_cache.use_kernel_cache([tmp_path / "file"])
    assert Path(os.environ["NUMBA_CACHE_DIR"]).is_dir()
    assert capsys.readouterr().err.count("no writable folder") == 1


@pytest.mark.usefixtures("before_numba")
@pytest.mark.parametrize("inside", ["", "kernels", "named"])
def test_nothing_is_kept_where_others_may_write(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    inside: str,
) -> None:
    """Numba would run what they leave there; and what is made is for its owner alone."""
    cache = tmp_path / "cache"
    kernel_cache.use_kernel_cache([cache])
    kernels = Path(os.environ.pop("NUMBA_CACHE_DIR"))
    assert [path.stat().st_mode & 0o777 for path in (cache, kernels)] == [0o700, 0o700]
    other = {"": cache, "kernels": kernels, "named": tmp_path / "named"}[inside]
    other.mkdir(exist_ok=True)
    if os.geteuid() == 0:
        os.chown(other, 65534, -1)
    else:
        other.chmod(0o770)
    if inside == "named":
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(other))
    kernel_cache.use_kernel_cache([cache])
    assert Path(os.environ["NUMBA_CACHE_DIR"]) != other
    assert "others may write there: chmod go-w" in capsys.readouterr().err


@pytest.mark.usefixtures("before_numba")
def test_a_named_folder_has_precedence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "named"))
    kernel_cache.use_kernel_cache([tmp_path])
    assert os.environ["NUMBA_CACHE_DIR"] == str(tmp_path / "named")


@pytest.mark.usefixtures("before_numba")
@pytest.mark.parametrize("named", ["file", "full"])
def test_a_named_folder_that_cannot_hold_kernels_is_said_and_passed_over(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], named: str
) -> None:
    (tmp_path / "file").write_text("no folder")
    usage = shutil.disk_usage
    left = {str(tmp_path / "full"): 2**20}
    monkeypatch.setattr(
        shutil, "disk_usage", lambda at: usage(at)._replace(free=left.get(str(at), 2**40))
    )
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / named))
    kernel_cache.use_kernel_cache([tmp_path / "cache"])
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == tmp_path / "cache"
    err = capsys.readouterr().err
    assert (err.count("\n"), "it cannot hold compiled kernels" in err) == (1, True)
    kernel_cache.use_kernel_cache([tmp_path / "cache"])
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("before_numba")
def test_few_old_folders_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for k in range(kernel_cache.KEPT + 2):
        (tmp_path / f"kernels-{k}").mkdir()
        os.utime(tmp_path / f"kernels-{k}", (k, k))
    kernel_cache.use_kernel_cache([tmp_path])
    left = {each.name for each in tmp_path.iterdir()}
    assert left == {
        *(f"kernels-{k}" for k in range(3, kernel_cache.KEPT + 2)),
        Path(os.environ["NUMBA_CACHE_DIR"]).name,
    }
