"""Whatever asks a program to end ends it tidily, once, with the code that shells know."""

import os
import signal
import subprocess
import sys
import time

import pytest

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PROGRAM = """
import os, signal, sys, time
from scenes.processes.streams import Stopped, load_usd, raise_when_stopped, signals_held

raise_when_stopped()
try:
    {body}
    print("ready", flush=True)
    time.sleep(60)
except Stopped as stopped:
    {at_the_end}
    print("tidied", flush=True)
    sys.exit(stopped.exit_code)
"""


def started(body="pass", at_the_end="pass", **kind):
    """The program, once it is ready."""
    words = [sys.executable, "-c", PROGRAM.format(body=body, at_the_end=at_the_end)]
    process = subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **kind
    )
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("number", ENDING, ids=lambda each: each.name)
def test_each_signal_ends_it_tidily(number):
    process = started()
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (128 + number, "tidied\n", "")


@pytest.mark.parametrize("then", ENDING[:2], ids=lambda each: each.name)
def test_a_second_signal_ends_it_at_once_if_it_is_ctrl_c_alone(then):
    process = started(at_the_end="print('ends', flush=True); time.sleep(3)")
    process.send_signal(signal.SIGHUP)
    assert process.stdout.readline() == "ends\n"
    time.sleep(1.2)  # sooner it would be the first one once more
    process.send_signal(then)
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 129
    assert out == ("" if then == signal.SIGINT else "tidied\n")


def test_one_press_that_arrives_twice_is_one_signal():
    process = started(at_the_end="print('ends', flush=True); time.sleep(0.3)")
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "ends\n"
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=30)
    assert (process.returncode, out) == (130, "tidied\n")


def test_nohup_keeps_it_going():
    process = started(preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    process.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=30)
    assert process.returncode == 143


def test_one_that_comes_where_nothing_can_be_raised_comes_again():
    dying = (
        "class Dying:\n        def __del__(self, kill=os.kill):\n"
        "            kill(os.getpid(), signal.SIGTERM); time.sleep(0.01)\n    Dying()"
    )
    words = [sys.executable, "-c", PROGRAM.format(body=dying, at_the_end="pass")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout.splitlines()[-1], done.stderr) == (143, "tidied", "")


def test_what_is_started_while_signals_are_held_leaves_its_end_to_its_parent():
    sleeps = "import subprocess\n    with signals_held():\n        child = subprocess.Popen("
    body = f"{sleeps}['sleep', '60'])"
    at_the_end = "time.sleep(0.3); print(child.poll()); child.kill(); child.wait()"
    process = started(body, at_the_end, start_new_session=True)
    os.killpg(process.pid, signal.SIGTERM)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (143, "None\ntidied\n", "")


def test_one_that_comes_while_they_are_held_is_raised_afterwards():
    body = (
        "with signals_held():\n        os.kill(os.getpid(), signal.SIGTERM)\n"
        "        print('held', flush=True)"
    )
    words = [sys.executable, "-c", PROGRAM.format(body=body, at_the_end="pass")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout) == (143, "held\ntidied\n")


def test_a_library_that_swallows_what_is_raised_while_it_loads_swallows_no_signal():
    loading = """import types

    class Loading(types.ModuleType):
        def __getattr__(self, name):
            try:
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(0.01)
            except BaseException as error:
                print("swallowed", error)

    sys.modules["pxr"] = Loading("pxr")
    load_usd()"""
    words = [sys.executable, "-c", PROGRAM.format(body=loading, at_the_end="pass")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout) == (143, "tidied\n")
