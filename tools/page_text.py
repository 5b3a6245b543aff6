# SPDX-License-Identifier: Apache-2.0
"""Numbers and tables as generated pages show them."""


def metres(value):
    if value is None:
        return "-"
    for limit, scale, unit in ((0.9995, 1, "m"), (0.00995, 100, "cm"), (9.95e-6, 1e3, "mm"), (0, 1e6, "um")):
        if value >= limit:
            return f"{number(value * scale)} {unit}"
    return "0"


def number(value, digits=2):
    if value is None:
        return "-"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if abs(value) >= 100 or "e+" in text else text  # 99.7 is 100, not 1e+02


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def filled(template, words):
    """Every {{WORD}} by its text; a word that is missing or left over is an error."""
    for word, text in words.items():
        if "{{" + word + "}}" not in template:
            raise KeyError(f"the template does not ask for {word}")
        template = template.replace("{{" + word + "}}", text)
    if "{{" in template:
        raise KeyError("the template asks for " + template.split("{{")[1].split("}}")[0])
    return template
