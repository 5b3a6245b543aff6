#!/usr/bin/env python3
"""Fails on files and functions that are too long to be read at once.

A file holds one idea: at most FILE_LINES_MAX lines. A function is seen whole: 60 lines of code with
their comments are what a screen shows beside a title bar, at the size of text people work with. There
are no exceptions.
"""
import ast
import re
import sys

from source_files import ROOT, report, source_files

FILE_LINES_MAX = 450
FUNCTION_LINES_MAX = 60

CURLY = (".h", ".hpp", ".c", ".cpp", ".glsl", ".comp", ".vert", ".frag")
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'',
                      re.DOTALL)
NOT_FUNCTIONS = re.compile(r"^\s*(?:if|for|while|switch|catch|else|do|try|namespace|extern)\b|[=\]]\s*\(")
HEAD = re.compile(r"([~\w:]+|operator\S+)\s*\((?:[^;{}]*)\)[^;{}()]*$", re.DOTALL)
INITIALISED = re.compile(r"\)[^:]*:[^:].*\w\s*$", re.DOTALL)


def blank(match):
    """Comments and texts become blanks, line by line, so that no brace in them counts."""
    return re.sub(r"[^\n]", " ", match.group(0))


def curly_functions(text):
    """(name, first line, lines) of each function that is not inside another."""
    text = NOT_CODE.sub(blank, re.sub(r"^\s*#.*?(?<!\\)$", "", text, flags=re.M))
    inside = []      # of each open brace: (name, first line) of a function, None for another
    head_start = 0
    for at, character in enumerate(text):
        if character == ";":
            head_start = at + 1
        elif character == "{":
            head = text[head_start:at]
            if not any(inside) and INITIALISED.search(head):
                inside.append(())  # a member's first value: the head goes on behind it
                continue
            match = None if any(inside) or NOT_FUNCTIONS.search(head) else HEAD.search(head)
            first = text.count("\n", 0, head_start + len(head) - len(head.lstrip())) + 1
            inside.append((signature_name(head), first) if match else None)
            head_start = at + 1
        elif character == "}" and inside:
            function = inside.pop()
            if function == ():
                text = text[:at] + " " + text[at + 1:]
                continue
            if function:
                yield (*function, text.count("\n", 0, at) + 2 - function[1])
            head_start = at + 1


def signature_name(head):
    head = " ".join(head.split())
    test = re.search(r"\bTEST(?:_F|_P)?\((\w+), (\w+)\)", head)
    if test:
        return f"{test.group(1)}.{test.group(2)}"
    return re.search(r"([~\w:]+|operator\S+)\s*\(", head).group(1)


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            yield node.name, node.lineno, node.end_lineno - node.lineno + 1


def main():
    problems = []
    files = source_files(*CURLY, ".py")
    for path in files:
        text = (ROOT / path).read_text()
        lines = text.count("\n")
        if lines > FILE_LINES_MAX:
            problems.append(f"{path}: {lines} lines; a file has at most {FILE_LINES_MAX}")
        for name, first, length in (python_functions if path.endswith(".py") else curly_functions)(text):
            if length > FUNCTION_LINES_MAX:
                problems.append(f"{path}:{first}: {name} has {length} lines; at most {FUNCTION_LINES_MAX}")
    return report(problems, f"lengths: {len(files)} files, every function fits a screen")


if __name__ == "__main__":
    sys.exit(main())
