#!/usr/bin/env python3
"""A preprocessor of mdBook for what GitHub shows by itself: TeX becomes MathML, and links out of docs/ plain text.

    pip install -r docs/requirements.txt && mdbook build docs
"""

import json
import re
import sys

from latex2mathml.converter import convert

CODE = r"(?P<code>^[ ]*```.*?^[ ]*```|`[^`\n]*`)"
DISPLAY = r"\$\$(?P<display>.+?)\$\$"
INLINE = r"\$(?P<inline>[^$\n]+?)\$"
OUT = r"\[(?P<text>[^\]\n]*)\]\(\.\./[^)\n]*\)"
PARTS = re.compile("|".join((CODE, DISPLAY, INLINE, OUT)), re.DOTALL | re.MULTILINE)


FUNCTION = re.compile(r"<mi>(arctan|cos|log|sin|tan|tanh)</mi>(<mo[^>]*>(?:\(|&#x00028;))?")
THIN = '<mspace width="0.17em"/>'
# A minus behind a relation, a comma or an open parenthesis is a sign.
SIGN = re.compile(r"(<mo[^>]*>(?:&#x0003D;|&#x0002C;|&#x00028;|\()</mo>)<mo>(?=&#x02212;)")


def math(tex: str, display: str) -> str:
    # Bars are a pair, not relations.
    tex = tex.strip().replace(r"\lvert", r"\left\lvert").replace(r"\rvert", r"\right\rvert")
    apart = lambda own: THIN + own[0] + ("" if own[2] else THIN)
    text = FUNCTION.sub(apart, convert(tex, display=display))
    text = SIGN.sub(r'\1<mo form="prefix">', text)
    # Nothing between the tags is Markdown.
    escape = lambda own: re.sub(r"[*_`\\|\[\]~$]", lambda mark: f"&#{ord(mark[0])};", own[0])
    return re.sub(r">[^<]+<", escape, text)


def shown(part: re.Match) -> str:
    if part["display"] is not None:
        return math(part["display"], "block")
    if part["inline"] is not None:
        return math(part["inline"], "inline")
    return part["text"] if part["text"] is not None else part[0]


def walk(items: list) -> None:
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter:
            chapter["content"] = PARTS.sub(shown, chapter["content"])
            walk(chapter["sub_items"])


if __name__ == "__main__":
    if sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2] != "html")
    _, book = json.load(sys.stdin)
    walk(book["items"])
    json.dump(book, sys.stdout)
