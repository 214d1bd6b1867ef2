"""The session of Gmsh leaves the process as it was."""

import subprocess
import sys

import pytest

WRITES = """
import os
from threading import Thread
from femic.reference.meshing import gmsh_session

def meshes():
    with gmsh_session():
        pass

{call}
reads, writes = os.pipe()
os.close(reads)
try:
    os.write(writes, b"to nobody")
except BrokenPipeError:
    print("raised")
"""


@pytest.mark.parametrize("call", ["meshes()", "one = Thread(target=meshes); one.start(); one.join()"])
def test_write_to_a_closed_connection_does_not_end_a_process_after_meshing(call):
    """Such as a campaign, when a worker is killed; also where a thread has meshed, as in workers."""
    ended = subprocess.run(
        [sys.executable, "-c", WRITES.format(call=call)], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout) == (0, "raised\n"), ended.stderr
