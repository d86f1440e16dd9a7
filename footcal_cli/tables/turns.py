"""Lines of several metrics (Prometheus) or topics (MQTT) that take turns, as rows by their stamps.

Room: tables; asked by foreign, read by `footcal_cli.formats.records`.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping

TURNS = "lines of metrics or topics that take turns"
_NUMBER = r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|NaN|Inf)"
_METRIC = re.compile(
    rf"(?P<name>[A-Za-z_:][\w:]*)(?:\{{(?P<labels>[^{{}}]*)\}})?\s+(?P<said>{_NUMBER})\s+"
    r"(?P<at>\d{13})"
)
"""``load_kg{rig="a"} 0.5 1710237600000``, the stamp in ms."""
_SENT = re.compile(
    rf"(?P<at>\d{{9,10}}(?:\.\d+)?|\d{{4}}-\d\d-\d\d[T ]\d\d:\d\d:\d\d\S*)\s+"
    rf"(?P<name>[\w.-]*(?:/[\w.-]+)+)\s+(?P<said>\{{.*\}}|{_NUMBER})"
)
"""``1710237600.05 dog/fl/wrench {"fx": 0.1, …}``, as ``mosquitto_sub`` prints topics."""
_LABEL = re.compile(r'(\w+)="([^"]*)"')
_ALIKE, _LOOKED_AT, _EACH = 0.8, 400, 3


def take_turns(text: str) -> bool:
    """Whether a text is of such lines, of two names at least."""
    lines = [x for x in text.splitlines()[:_LOOKED_AT] if x.strip() and not x.startswith("#")]
    for form in (_METRIC, _SENT):
        found = Counter(m["name"] for x in lines if (m := form.fullmatch(x.strip())))
        often = [name for name, count in found.items() if count >= _EACH]
        if len(often) > 1 and found.total() >= _ALIKE * len(lines):
            return True
    return False


def rows_of_turns(text: str) -> list[dict[str, str]]:
    """One row per stamp, a column for each metric or each number of a topic; empty without."""
    if not take_turns(text):
        return []
    rows: dict[str, dict[str, str]] = {}
    clock = ""
    lines = [line.strip() for line in text.splitlines()]
    named = _names([found for line in lines if (found := _METRIC.fullmatch(line))])
    for line in lines:
        if found := _METRIC.fullmatch(line):
            clock = "time_ms"
            said = {named[found["name"], found["labels"] or ""]: found["said"]}
        elif found := _SENT.fullmatch(line):
            clock = "time"
            said = dict(_payload(found["name"], found["said"]))
        else:
            continue
        rows.setdefault(found["at"], {}).update(said)
    return [{clock: at, **said} for at, said in rows.items()]


def _names(metrics: list[re.Match[str]]) -> Mapping[tuple[str, str], str]:
    """Columns of metrics: their name, and the labels by which those of one name differ."""
    keys = dict.fromkeys((m["name"], m["labels"] or "") for m in metrics)
    several = Counter(name for name, _ in keys)
    every = {name: [dict(_LABEL.findall(ls)) for n, ls in keys if n == name] for name in several}
    named = {}
    for name, labels in keys:
        own = dict(_LABEL.findall(labels))
        differ = [v for k, v in own.items() if any(o.get(k) != v for o in every[name])]
        named[name, labels] = ".".join([*differ, name]) if several[name] > 1 else name
    return named


def _payload(name: str, said: str) -> Iterator[tuple[str, str]]:
    """Numbers and texts of a topic's message by dotted names behind the topic."""
    if not said.startswith("{"):
        yield name, said
        return
    try:
        waiting = [(name, json.loads(said))]
    except ValueError:
        return
    while waiting:
        stem, value = waiting.pop(0)
        if isinstance(value, dict):
            waiting = [*((f"{stem}/{key}", one) for key, one in value.items()), *waiting]
        elif isinstance(value, list):
            waiting = [*((f"{stem}_{i}", one) for i, one in enumerate(value)), *waiting]
        elif value is not None:
            yield stem, str(value)
