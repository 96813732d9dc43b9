"""A release is one thing: every file names its version, and what is built installs and renders."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RELEASES = r"^## \[(\d[^\]]*)\] - \d{4}-\d{2}-\d{2}$"  # of the changelog, the newest first


def first_in(name: str, pattern: str) -> str:
    found = re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.M)
    assert found, f"{name}: nothing reads {pattern}"
    return found[1]


def test_every_file_names_the_version_of_pyproject() -> None:
    named = {
        "CITATION.cff": first_in("CITATION.cff", r"^version: (\S+)$"),
        "CHANGELOG.md": first_in("CHANGELOG.md", RELEASES),
        "what is installed": version("lodbench"),  # which headers, records and --version name
    }
    assert named == dict.fromkeys(named, PROJECT["version"])


def done(*words: str | Path, cwd: Path, **more: str) -> str:
    """Run a program as a user would, without what the tests set for their own imports."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    ended = subprocess.run(
        [*map(str, words)], cwd=cwd, env=kept | more, capture_output=True, text=True
    )
    assert ended.returncode == 0, f"{words}: {ended.stderr}"
    return ended.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheel and the sdist of the working tree, by the backend that the lock brings."""
    folder = tmp_path_factory.mktemp("built")
    done(sys.executable, "-m", "hatchling", "build", "-d", folder, cwd=ROOT)
    name = f"lodbench-{PROJECT['version']}"
    return {"wheel": folder / f"{name}-py3-none-any.whl", "sdist": folder / f"{name}.tar.gz"}


def fresh_environment(folder: Path) -> Path:
    """A new environment that finds the dependencies where the tests have them; gives its Python.

    What the tests have installed of lodbench itself comes last there, and is editable: its path
    stands in a file of site-packages that no other environment reads.
    """
    venv.create(folder, with_pip=False, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    others = {sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (site / "dependencies.pth").write_text("\n".join(sorted(others)) + "\n", encoding="utf-8")
    return folder / "bin" / "python"


def install_into(python: Path) -> tuple[str | Path, ...]:
    """The words that install something into an environment, and nothing else."""
    pip = (sys.executable, "-m", "pip", "--isolated", "--python", python, "install", "--quiet")
    return *pip, "--no-deps", "--no-index", "--no-build-isolation", "--ignore-installed"


@pytest.mark.slow
def test_the_sdist_builds_the_very_wheel(built: dict[str, Path], tmp_path: Path) -> None:
    shutil.unpack_archive(built["sdist"], tmp_path)
    (sources,) = tmp_path.iterdir()
    done(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", tmp_path, cwd=sources)
    (again,) = tmp_path.glob("*.whl")
    assert again.read_bytes() == built["wheel"].read_bytes()


@pytest.fixture(scope="module")
def installed(built: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with an environment that has the wheel."""
    folder = tmp_path_factory.mktemp("installed")
    done(*install_into(fresh_environment(folder / "environment")), built["wheel"], cwd=folder)
    return folder


@pytest.mark.slow
def test_what_is_built_installs_and_renders_without_the_sources(
    installed: Path, tmp_path: Path
) -> None:
    python = installed / "environment" / "bin" / "python"
    where = "import lodbench, bench, scenes, lod; print(lodbench.__file__, *bench.__path__)"
    for path in done(python, "-c", where, cwd=tmp_path).split():
        assert Path(path).is_relative_to(installed), path

    program = python.with_name("lodbench")
    said = done(program, "--version", cwd=tmp_path)
    assert said == f"lodbench, version {PROJECT['version']}\n"
    small = ("--size", "32x18", "--spp", "1", "--variant", "scalar_rgb")
    cache = {"LODBENCH_CACHE": str(installed / "cache")}
    done(program, "render", "fly_in", "-o", "out/a.####.exr", *small, cwd=tmp_path, **cache)
    assert (tmp_path / "out/a.0001.exr").stat().st_size > 32 * 18
    done(program, "verify", "out", cwd=tmp_path)


@pytest.mark.slow
def test_the_example_package_installs_beside_lodbench(installed: Path, tmp_path: Path) -> None:
    python = installed / "environment" / "bin" / "python"
    example = shutil.copytree(ROOT / "examples" / "plugin", tmp_path / "plugin")
    done(*install_into(python), example, cwd=tmp_path)
    program, cache = python.with_name("lodbench"), {"LODBENCH_CACHE": str(installed / "cache")}
    assert "halfway" in done(program, "list", cwd=tmp_path, **cache)
    few = ("--size", "64x36", "-D", "species={one={model='rabbit', density=0.1}}", "--json")
    counts = {
        metric: json.loads(
            done(program, "count", "meadow", "--metric", metric, *few, cwd=tmp_path, **cache)
        )
        for metric in ("halfway", "blake")
    }
    assert counts["halfway"] != counts["blake"]
