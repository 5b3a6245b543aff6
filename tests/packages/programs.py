"""What the README's program is and how it is built: taken from the page, for every test that runs it."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PORT = "9430"


def use_it_in_your_program():
    """The C program and the commands of the section, as they stand there."""
    section = (ROOT / "README.md").read_text().split("\n## Use it in your program\n")[1].split("\n## ")[0]
    program, = re.findall(r"```c\n(.*?)```", section, re.S)
    commands, = re.findall(r"```sh\n(.*?)```", section, re.S)
    return program, commands.strip().splitlines()
