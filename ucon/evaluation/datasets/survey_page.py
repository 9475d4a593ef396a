"""The rating sheet as one HTML file, to be printed or filled in in a browser, which saves the CSV."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

from ucon.evaluation.datasets.survey import LOOK, QUESTIONS, SHEET_FIELDS, RatedHabit

_STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; color: #1f2937; max-width: 46rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .3rem; }
.item { border-top: 1px solid #d1d5db; padding: .9rem 0; break-inside: avoid; display: flex; gap: 1rem; }
.number { color: #6b7280; min-width: 2rem; text-align: right; }
.item > div { flex: 1; }
.habit { font-size: 1.1rem; margin: 0 0 .3rem; }
.about { margin: 0 0 .6rem; }
.about b { color: #0f766e; }
fieldset { border: 0; padding: 0; margin: .25rem 0; display: flex; flex-wrap: wrap; gap: .2rem 1.1rem; }
legend { float: left; min-width: 21rem; color: #4b5563; font-size: .92rem; }
button { font: inherit; padding: .6rem 1.4rem; background: #0f766e; color: white; border: 0; border-radius: .4rem; }
@media print { button, .screen { display: none; } body { margin: 0; font-size: 12px; } }
"""
_SCRIPT = """
function cell(text) { return /[",\\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text; }
document.getElementById('save').addEventListener('click', () => {
  const rows = [HEAD];
  for (const item of document.querySelectorAll('.item')) {
    const said = name => (item.querySelector(`input[name="${name}${item.dataset.item}"]:checked`) || {value: ''}).value;
    const {item: number, object, habit, place} = item.dataset;
    rows.push([number, object, habit, place, said('real'), said('look')]);
  }
  const text = rows.map(row => row.map(cell).join(',') + '\\n').join('');
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], {type: 'text/csv'}));
  link.download = 'NAME';
  link.click();
});
"""


def sheet_html(items: Sequence[RatedHabit], name: str) -> str:
    """The sheet as a page; it contains nothing of the key.

    Args:
        items: of the survey.
        name: file name under which the browser saves the answers.
    """
    cards = "\n".join(_card(item) for item in items)
    script = _SCRIPT.replace("HEAD", json.dumps(list(SHEET_FIELDS))).replace("'NAME'", _text(name))
    return f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Habits and places: rating sheet</title><style>{_STYLE}</style>
<h1>Habits and places: {len(items)} items</h1>
<p>Each item gives a sentence about somebody's habits, an OBJECT, and a PLACE. Please answer two questions for each;
skip what you cannot answer. There are no right answers to the first question, and this is not a test.</p>
<ol><li>{escape(QUESTIONS[0])}</li><li>{escape(QUESTIONS[1])}</li></ol>
<p class="screen">At the end, <em>Save answers</em> writes a CSV file: put your initials into its name and
return it.</p>
{cards}
<p><button id="save" type="button">Save answers</button></p>
<script>{script}</script>
</html>
"""


def _card(item: RatedHabit) -> str:
    number = item.item
    data = f'data-item="{number}" data-object="{escape(item.object)}" data-habit="{escape(item.habit)}"'
    return f"""<div class="item" {data} data-place="{escape(item.place)}"><span class="number">{number}</span><div>
<p class="habit">&ldquo;{escape(item.habit)}&rdquo;</p>
<p class="about">OBJECT: <b>{escape(item.object)}</b> &nbsp; PLACE: <b>{escape(item.place)}</b></p>
{_choice(number, "real", "A habit a real person could have?", ("1", "2", "3", "4", "5"))}
{_choice(number, "look", "Would you look for the object there?", LOOK)}
</div></div>"""


def _choice(number: int, name: str, question: str, values: Sequence[str]) -> str:
    marks = "".join(f'<label><input type="radio" name="{name}{number}" value="{v}"> {v}</label>' for v in values)
    return f"<fieldset><legend>{question}</legend>{marks}</fieldset>"


def _text(value: str) -> str:
    """A JavaScript string literal that cannot close the script element."""
    return json.dumps(value).replace("<", "\\u003c")
