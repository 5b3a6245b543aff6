# SPDX-License-Identifier: Apache-2.0
"""seaway-server as a child of a test, on a free port of 127.0.0.1. Tests find it beside folder.h:

    sys.path.append(str(ROOT / "tests/support"))
    from served import Served
"""
import re
import subprocess


class Served:
    """Of the program, its scene and its options; serves until stop() or the end of a block. `options`: as subprocess.Popen has them."""

    def __init__(self, *command, stderr=subprocess.DEVNULL, **options):
        words = [*map(str, command), *([] if "--listen" in command else ["--listen", "127.0.0.1:0"])]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=stderr, text=True, **options)
        ready = re.match(r"ready ws://127\.0\.0\.1:(\d+)", self.process.stdout.readline())
        if not ready:
            self.stop()
            raise OSError("the server does not start")
        self.port = int(ready.group(1))
        self.url = f"ws://127.0.0.1:{self.port}"

    def stop(self):
        """Also where it has ended; what it wrote to stderr, if that was asked for (subprocess.PIPE)."""
        self.process.terminate()
        said = self.process.stderr.read() if self.process.stderr and not self.process.stderr.closed else ""
        self.process.wait(timeout=60)
        self.process.stdout.close()
        return said

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
