"""What keeps somebody from using a page: names, contrast, headings, focus, and width.

A small judge of pages of its own, in place of a package: it asks the browser for the tree that
screen readers get, and measures what is drawn.
"""

from __future__ import annotations

import json
from typing import Any

from browser import Browser

CONTROLS = {
    "button", "checkbox", "combobox", "DisclosureTriangle", "Iframe", "image", "img", "link",
    "listbox", "progressbar", "radio", "searchbox", "slider", "spinbutton", "textbox",
}  # fmt: skip
"""Roles that are nothing without a name."""

MEASURED = r"""
(() => {
  const found = [];
  const named = (element) => element.tagName.toLowerCase() + (element.id ? "#" + element.id : "")
    + (element.className?.length ? "." + element.className : "");
  const all = [...document.querySelectorAll("body *")];
  const seen = (element) => element.checkVisibility({ visibilityProperty: true })
    && element.getClientRects().length > 0;

  // Ids, and what refers to them.
  const ids = all.map(({ id }) => id).filter(Boolean);
  for (const id of new Set(ids)) {
    if (ids.filter((other) => other === id).length > 1) found.push(`id ${id} stands twice`);
  }
  for (const name of ["for", "aria-labelledby", "aria-describedby", "aria-controls"]) {
    for (const element of document.querySelectorAll(`[${name}]`)) {
      for (const id of element.getAttribute(name).split(/\s+/).filter(Boolean)) {
        if (document.getElementById(id)) continue;
      found.push(`${named(element)}: ${name} ${id} leads nowhere`);
      }
    }
  }

  // One main part, and headings without gaps.
  if (document.querySelectorAll("main").length !== 1) found.push("not one main part");
  if (!document.documentElement.lang) found.push("no language");
  if (!document.title) found.push("no title");
  const levels = all.filter((each) => /^H[1-6]$/.test(each.tagName) && seen(each))
    .map(({ tagName }) => Number(tagName[1]));
  if (levels.filter((level) => level === 1).length !== 1) found.push("not one first heading");
  levels.forEach((level, at) => {
    if (level > (levels[at - 1] ?? 0) + 1) found.push(`heading ${at + 1} has level ${level}`);
  });

  // Contrast of text with what is behind it (WCAG 2.2, 1.4.3); colours by a canvas.
  const pen = Object.assign(document.createElement("canvas"), { width: 1, height: 1 })
    .getContext("2d", { willReadFrequently: true });
  const parts = (colour) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    const [red, green, blue, alpha] = pen.getImageData(0, 0, 1, 1).data;
    return [red, green, blue, alpha / 255];
  };
  const over = (front, back) =>
    [0, 1, 2].map((at) => front[at] * front[3] + back[at] * (1 - front[3])).concat(1);
  const behind = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      layers.push(getComputedStyle(at).backgroundColor);
    }
    return layers.reverse().reduce((back, colour) => over(parts(colour), back), [255, 255, 255, 1]);
  };
  const light = (colour) => {
    const [red, green, blue] = colour.slice(0, 3).map((value) => value / 255)
      .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const judged = new Set();
  while (words.nextNode()) {
    const element = words.currentNode.parentElement;
    if (!words.currentNode.data.trim() || judged.has(element) || !seen(element)) continue;
    judged.add(element);
    if (element.closest(":disabled, .away, option, noscript")) continue;
    const style = getComputedStyle(element);
    const back = behind(element);
    const colour = element.closest("svg") ? style.fill : style.color;
    const [first, second] = [light(over(parts(colour), back)), light(back)].sort((a, b) => b - a);
    const ratio = (first + 0.05) / (second + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    if (ratio < (large ? 3 : 4.5)) {
      const said = element.textContent.trim().slice(0, 30);
      found.push(`${named(element)} "${said}": contrast ${ratio.toFixed(2)}`);
    }
  }

  // Nothing is beyond the window, but for what can be scrolled to.
  const clipped = (element) => {
    for (let at = element.parentElement; at && at !== document.body; at = at.parentElement) {
      if (getComputedStyle(at).overflowX !== "visible") return true;
    }
    return false;
  };
  for (const element of all.filter(seen)) {
    const { left, right } = element.getBoundingClientRect();
    if ((right > innerWidth + 1 || left < -1) && !clipped(element)) {
      found.push(`${named(element)}: from ${Math.round(left)} to ${Math.round(right)} px`);
    }
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push("the page scrolls sideways");
  return found;
})()
"""
"""What is measured in the page."""

FOCUSED = r"""
(() => {
  const found = [];
  const could = "a[href], button, input, select, textarea, summary, [tabindex]";
  const before = document.activeElement;
  for (const element of document.querySelectorAll(could)) {
    const seen = element.checkVisibility({ visibilityProperty: true });
    if (!seen || element.matches(":disabled")) continue;
    element.focus({ preventScroll: true });
    if (document.activeElement !== element) continue;
    const marked = [element, element.parentElement].some((each) => {
      const { outlineStyle, outlineWidth, boxShadow } = getComputedStyle(each);
      return outlineStyle === "auto"
        || (outlineStyle !== "none" && parseFloat(outlineWidth) >= 1.5) || boxShadow !== "none";
    });
    if (!marked) found.push(`${element.tagName.toLowerCase()}#${element.id}: focus is not seen`);
  }
  before?.focus?.({ preventScroll: true });
  return found;
})()
"""
"""What does not show that it has the focus."""


def barriers(tab: Browser) -> list[str]:
    """What is wrong with a page as it stands, one line each; empty if nothing is.

    Parameters
    ----------
    tab : Browser
    """
    # Focus is drawn for those who work by keys.
    for kind in ("keyDown", "keyUp"):
        tab.call(
            "Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9
        )
    found: list[str] = [*_nameless(tab), *tab.evaluate(MEASURED), *tab.evaluate(FOCUSED)]
    return found


def _nameless(tab: Browser) -> list[str]:
    nodes: list[dict[str, Any]] = tab.call("Accessibility.getFullAXTree")["nodes"]
    found = []
    for node in nodes:
        role = node.get("role", {}).get("value")
        if node.get("ignored") or role not in CONTROLS or node.get("name", {}).get("value"):
            continue
        asked = tab.call("DOM.resolveNode", backendNodeId=node["backendDOMNodeId"])["object"]
        html = tab.call(
            "Runtime.callFunctionOn", objectId=asked["objectId"],
            functionDeclaration="function () { return this.outerHTML.slice(0, 80); }",
        )["result"].get("value")  # fmt: skip
        found.append(f"{role} without a name: {json.dumps(html)}")
    return found
