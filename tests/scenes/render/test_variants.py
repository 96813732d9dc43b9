"""The probe survives libraries that refuse, abort or are not there, and says why."""

import os
import subprocess
import sys

import pytest

from lod.errors import InputError
from scenes.render import variants


def probe_with(library, expression):
    code = f"from scenes.render import variants; print({expression})"
    environment = {**os.environ, variants.LLVM_PATH: str(library)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_without_libllvm_auto_is_scalar(tmp_path):
    answer = probe_with(tmp_path / "none.so", "variants.choose('auto'), variants.libllvm()")
    assert answer.strip() == "scalar_rgb None"


def test_a_file_that_is_no_library_is_refused_with_a_reason(tmp_path):
    fake = tmp_path / "libLLVM-99.so"
    fake.write_text("not a library")
    answer = probe_with(fake, "variants.works('llvm_ad_rgb'), variants.choose('auto')")
    assert "libLLVM-99.so" in answer and "scalar_rgb" in answer


def test_asked_for_and_missing_raises_with_a_cure(monkeypatch):
    monkeypatch.setattr(variants, "works", lambda name: "no libLLVM was found")
    for system, cure in (("linux", "libllvm19"), ("darwin", "brew"), ("win32", "LLVM-C.dll")):
        monkeypatch.setattr(variants.sys, "platform", system)
        monkeypatch.setattr(variants.platform, "machine", lambda: "aarch64")
        with pytest.raises(InputError, match=rf"{cure}.*--variant scalar_rgb"):
            variants.choose("llvm_ad_rgb")
    assert variants.choose("auto") == "scalar_rgb"


@pytest.mark.parametrize("name", ["", "llvm", "scalar_rgb ", "scalar_spectral", "cuda_ad_rgbx"])
def test_unknown_and_unusable_names(name):
    with pytest.raises(InputError, match="variant"):
        variants.choose(name)


IMPORTS = """
import os, sys
{first}
import lodbench, drjit
library = os.path.realpath(os.environ["DRJIT_LIBLLVM_PATH"])
maps = open("/proc/self/maps", encoding="utf-8").read()
sys.exit(0 if library in maps else 1)
"""


@pytest.mark.skipif(not variants.packaged_library(), reason="the environment has no libLLVM")
@pytest.mark.parametrize("first", ["", "import drjit"])
def test_the_library_that_is_loaded_is_the_one_that_is_tried(first):
    """The environment's, or the one that a caller's Dr.Jit has loaded before."""
    kept = {name: value for name, value in os.environ.items() if name != variants.LLVM_PATH}
    subprocess.run([sys.executable, "-c", IMPORTS.format(first=first)], env=kept, check=True)


@pytest.mark.slow
def test_probe_answers_for_every_variant():
    probe = variants.probe()
    assert probe.variants["scalar_rgb"] is True
    assert {"llvm_ad_rgb", "cuda_ad_rgb", "scalar_spectral"} <= set(probe.variants)
    assert all(answer is True or answer for answer in probe.variants.values())
