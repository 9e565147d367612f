"""What of an SVG drawing is hidden, clipped or moved: by attribute, style, or a rule of a style sheet (CSS 2.1, 6.4).

Only rules for single elements are read, as in `.hidden, path#old { display: none }`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

HIDING = {"display": ("none",), "visibility": ("hidden", "collapse")}
"""values that hide, by property"""
CLIPPING = ("clip-path", "mask")
"""properties that hide part of what they are given to, unless they are none"""
MOVING = ("transform", "transform-origin", "translate", "rotate", "scale", "offset-path")
"""properties that move what they are given to, unless they are none: the attribute `transform` is no such property"""
SELECTOR = re.compile(r"(?P<tag>[\w-]+|\*)?(?P<names>([.#][\w-]+)*)")


@dataclass(frozen=True, slots=True)
class Rule:
    """A value of a property for elements with a tag ("" for any), an id and classes; the `rank` of rules that win."""

    tag: str
    identity: str
    classes: frozenset[str]
    name: str
    value: str
    rank: tuple[int, int, int, int]

    def is_for(self, tag: str, element: Element) -> bool:
        """Return whether the rule is for an element."""
        known = self.identity in ("", element.get("id", "")) and self.classes <= {*element.get("class", "").split()}
        return known and self.tag in ("", tag)


def rules_in(sheets: list[str]) -> tuple[tuple[Rule, ...], list[str]]:
    """Return the rules of style sheets on what is hidden, clipped or moved, the one that wins last, and selectors of
    those that do so and are not read."""
    rules, unread = list[Rule](), list[str]()
    text = re.sub(r"/\*.*?\*/|<!--|-->", " ", "\n".join(sheets), flags=re.DOTALL)
    for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", text):
        said = {name: value for name, value in _declarations(body) if name in (*HIDING, *CLIPPING, *MOVING)}
        for selector in map(str.strip, selectors.split(",")):
            match = SELECTOR.fullmatch(selector)
            if match is None and any(_acts(name, value) for name, value in said.items()):
                unread.append(selector[:40])
            elif match is not None:
                rules += [_rule(match, name, value, len(rules)) for name, value in said.items()]
    return tuple(sorted(rules, key=lambda rule: rule.rank)), unread


def _acts(name: str, value: str) -> bool:
    """Return whether a value of a property hides all or part of an element, or moves it."""
    return value in HIDING[name] if name in HIDING else value not in ("", "none")


def _rule(match: re.Match[str], name: str, value: str, number: int) -> Rule:
    tag = (match["tag"] or "").replace("*", "")
    identities = re.findall(r"#([\w-]+)", match["names"])
    classes = frozenset(re.findall(r"\.([\w-]+)", match["names"]))
    rank = (len(identities), len(classes), bool(tag), number)
    return Rule(tag, (identities or [""])[-1], classes, name, value, rank)


def _declarations(text: str) -> Iterator[tuple[str, str]]:
    for one in text.split(";"):
        name, _, value = one.partition(":")
        yield name.strip().lower(), value.replace("!important", "").strip().lower()


def is_taken_out(element: Element, tag: str, rules: tuple[Rule, ...]) -> bool:
    """Return whether an element and all that is in it are hidden."""
    return _value(element, tag, "display", rules) in HIDING["display"]


def is_unseen(element: Element, tag: str, rules: tuple[Rule, ...], inherited: bool) -> bool:
    """Return whether an element is hidden that is in one which is so or not (`inherited`)."""
    value = _value(element, tag, "visibility", rules)
    return inherited if value in ("", "inherit") else value in HIDING["visibility"]


def is_clipped(element: Element, tag: str, rules: tuple[Rule, ...]) -> bool:
    """Return whether part of an element and of all that is in it is hidden by a clip-path or a mask."""
    return any(_acts(name, _value(element, tag, name, rules)) for name in CLIPPING)


def moved_by(element: Element, tag: str, rules: tuple[Rule, ...]) -> str:
    """Return the property by which a style, or `transform-origin` beside a `transform`, moves an element; or ""."""
    origin = element.get("transform-origin", "") if "transform" in element.attrib else ""
    values = {name: _styled(element, tag, name, rules, "") for name in MOVING}
    values["transform-origin"] = values["transform-origin"] or origin
    return next((name for name, value in values.items() if _acts(name, value)), "")


def _value(element: Element, tag: str, name: str, rules: tuple[Rule, ...]) -> str:
    """Return the value of a property: of the element's style, else of the rule that wins, else of its attribute."""
    return _styled(element, tag, name, rules, element.get(name, "").strip().lower())


def _styled(element: Element, tag: str, name: str, rules: tuple[Rule, ...], otherwise: str) -> str:
    """Return the value of a property: of the element's style, else of the rule that wins, else `otherwise`."""
    styled = [value for key, value in _declarations(element.get("style", "")) if key == name]
    ruled = [rule.value for rule in rules if rule.name == name and rule.is_for(tag, element)]
    return [otherwise, *ruled, *styled][-1]
