"""What the README's program is and how it is built: taken from the page, for every test that runs it."""
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PORT = "9430"


def use_it_in_your_program():
    """The C program and the commands of the section, as they stand there."""
    section = (ROOT / "README.md").read_text().split("\n## Use it in your program\n")[1].split("\n## ")[0]
    program, = re.findall(r"```c\n(.*?)```", section, re.S)
    commands, = re.findall(r"```sh\n(.*?)```", section, re.S)
    return program, commands.strip().splitlines()


class Served:
    """seaway-server on a scene and a free port, until the block ends."""

    def __init__(self, command, **options):
        self.process = subprocess.Popen([*command, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True, **options)

    def __enter__(self):
        ready = re.match(r"ready ws://127\.0\.0\.1:(\d+)", self.process.stdout.readline())
        if not ready:
            self.__exit__()
            raise OSError("the server does not start")
        self.port = ready.group(1)
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()
