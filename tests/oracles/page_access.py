"""Whether people who see little, use no mouse or hold a phone can use a page: rules of our own.

The names of controls are those that Chromium hands to screen readers. Contrast is that of WCAG 2.2,
level AA, success criterion 1.4.3.
"""

from __future__ import annotations

from typing import Any

from browser import Browser

WIDE, PHONE = 1280, 390
HEIGHT = 844
SCHEMES = ("light", "dark")

NAMED = {
    "button",
    "checkbox",
    "combobox",
    "dialog",
    "DisclosureTriangle",
    "graphics-document",
    "image",
    "link",
    "listbox",
    "img",
    "menuitem",
    "meter",
    "option",
    "progressbar",
    "radio",
    "region",
    "searchbox",
    "slider",
    "spinbutton",
    "switch",
    "tab",
    "textbox",
    "Iframe",
}
"""Roles whose bearers must have a name."""

SPEAK_FOR_PICTURES = {"button", "link"}
"""Roles whose name is enough for a picture inside."""

SETTLED = """new Promise((done) => {
  const frames = () => requestAnimationFrame(() => requestAnimationFrame(done));
  setTimeout(frames, 120);
})"""
"""A page redraws its charts when its width or scheme changes."""

SHARED = r"""
const said = (one) => {
  const id = one.id ? `#${one.id}` : '';
  const kind = typeof one.className === 'string' && one.className.trim()
    ? `.${one.className.trim().split(/\s+/).join('.')}` : '';
  return `${one.localName}${id}${kind} ${JSON.stringify(one.textContent.trim().slice(0, 40))}`;
};
const reachable = 'a[href], button, input, select, textarea, [tabindex="0"]';
const shown = (one) => one.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true })
  && one.getClientRects().length > 0;
"""

STRUCTURE = r"""
const found = [];
const all = [...document.querySelectorAll('*')];
const ids = all.map(({ id }) => id).filter(Boolean);
for (const id of new Set(ids.filter((id, at) => ids.indexOf(id) !== at))) {
  found.push(`id twice: ${id}`);
}
if (!document.documentElement.lang) found.push('the page does not say its language');
if (!document.title.trim()) found.push('the page has no title');
const mains = [...document.querySelectorAll('main, [role="main"]')].filter(shown);
if (mains.length !== 1) found.push(`${mains.length} main parts`);
const heads = [...document.querySelectorAll('h1, h2, h3, h4, h5, h6')].filter(shown);
const firsts = heads.filter(({ localName }) => localName === 'h1');
if (firsts.length !== 1) found.push(`${firsts.length} first headings`);
let before = 0;
for (const head of heads) {
  const level = Number(head.localName[1]);
  if (level > before + 1) found.push(`heading after level ${before}: ${said(head)}`);
  if (!head.textContent.trim()) found.push(`heading without text: ${said(head)}`);
  before = level;
}
for (const one of all.filter(({ tabIndex }) => tabIndex > 0)) {
  found.push(`focus out of order: ${said(one)}`);
}
for (const key of ['for', 'aria-labelledby', 'aria-describedby', 'aria-controls']) {
  for (const one of document.querySelectorAll(`[${key}]`)) {
    for (const id of one.getAttribute(key).split(/\s+/).filter(Boolean)) {
      if (!document.getElementById(id)) found.push(`${key} of a missing ${id}: ${said(one)}`);
    }
  }
}
for (const one of document.querySelectorAll('[role="img"]')) {
  if (one.querySelector(reachable)) found.push(`a picture with controls inside: ${said(one)}`);
}
for (const one of document.querySelectorAll('th')) {
  if (shown(one) && !one.textContent.trim()) found.push(`column without a heading: ${said(one)}`);
}
const regions = [...document.querySelectorAll('[role="region"]')].filter(shown)
  .map((one) => one.getAttribute('aria-label')).filter(Boolean);
for (const name of new Set(regions.filter((name, at) => regions.indexOf(name) !== at))) {
  found.push(`region twice: ${name}`);
}
return found;
"""

LAYOUT = r"""
const found = [];
const width = document.documentElement.clientWidth; // a phone zooms out if that is exceeded
if (document.documentElement.scrollWidth > width) {
  found.push(`the page is ${document.documentElement.scrollWidth} px wide`);
}
const clips = (one) => getComputedStyle(one).overflowX !== 'visible';
for (const one of document.body.querySelectorAll('*')) {
  if (one.closest('svg') && one.localName !== 'svg') continue;
  if (!shown(one)) continue;
  const { overflowX, overflowY } = getComputedStyle(one);
  const scrolls = (/auto|scroll/.test(overflowX) && one.scrollWidth > one.clientWidth + 1)
    || (/auto|scroll/.test(overflowY) && one.scrollHeight > one.clientHeight + 1);
  if (scrolls && one.tabIndex < 0 && !one.querySelector(reachable)) {
    found.push(`scrolls by mouse only: ${said(one)}`);
  }
  const { left, right } = one.getBoundingClientRect();
  // For screen readers alone; and where plotly measures texts.
  const meant = one.matches('.away, .unseen, #js-plotly-tester');
  if (right > width + 1 || (left < -1 && !meant)) {
    let outer = one.parentElement;
    while (outer && outer !== document.body && !clips(outer)) outer = outer.parentElement;
    if (outer === document.body) {
      found.push(`wider than the window: ${said(one)}`);
    }
  }
}
return found;
"""

CONTRAST = r"""
const found = new Set();
const canvas = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
const known = new Map();
const parts = (text) => {
  if (!known.has(text)) {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = text;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    known.set(text, [r, g, b, a / 255]);
  }
  return known.get(text);
};
const over = ([r, g, b, a], under) =>
  [r, g, b].map((part, at) => a * part + (1 - a) * under[at]).concat(1);
const luminance = (shade) => {
  const [r, g, b] = shade.slice(0, 3).map((part) => {
    const share = part / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const ratio = (one, other) => {
  const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
};
// What is behind an element, and the opacity of all that holds it.
const probe = document.body.appendChild(document.createElement('span'));
probe.style.backgroundColor = 'Canvas';
const page = parts(getComputedStyle(probe).backgroundColor);
probe.remove();
const behind = (one) => {
  const line = [];
  let opacity = 1;
  for (let at = one; at; at = at.parentElement) {
    const style = getComputedStyle(at);
    if (style.backgroundImage !== 'none') return null;
    line.push(parts(style.backgroundColor));
    opacity *= Number(style.opacity);
  }
  return [line.reverse().reduce((under, shade) => over(shade, under), page), opacity];
};
// In a drawing, the last of the filled shapes around a text that were drawn before it.
const drawnBehind = (one, under) => {
  const outer = one.closest('svg');
  const box = one.getBoundingClientRect();
  const [x, y] = [(box.left + box.right) / 2, (box.top + box.bottom) / 2];
  let ground = under;
  for (const shape of outer.querySelectorAll('rect, path, circle, ellipse, polygon')) {
    if (!(shape.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_FOLLOWING)) break;
    const style = getComputedStyle(shape);
    if (style.fill === 'none' || style.fill.startsWith('url')) continue;
    const { left, right, top, bottom } = shape.getBoundingClientRect();
    if (!(left <= x && x <= right && top <= y && y <= bottom)) continue;
    const [r, g, b, a] = parts(style.fill);
    ground = over([r, g, b, a * Number(style.fillOpacity) * Number(style.opacity)], ground);
  }
  return ground;
};
const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
const fields = [...document.querySelectorAll('input, textarea, select')].filter((one) =>
  !['checkbox', 'radio', 'range', 'color', 'file', 'hidden'].includes(one.type));
const judged = new Set(fields);
while (texts.nextNode()) {
  const one = texts.currentNode.parentElement;
  if (!texts.currentNode.nodeValue.trim()) continue;
  if (!one.matches('script, style, option, noscript, title')) judged.add(one);
}
for (const one of judged) {
  if (!shown(one) || one.closest('[aria-hidden="true"]:not(svg *)')) continue;
  if (one.closest('button, input, select, textarea, fieldset')?.matches(':disabled')) continue;
  const style = getComputedStyle(one);
  const written = one.namespaceURI.endsWith('svg') ? style.fill : style.color;
  if (written === 'none') continue;
  const ground = behind(one);
  if (!ground) continue;
  const inDrawing = one.closest('svg') !== null;
  const opacity = ground[1];
  const under = inDrawing ? drawnBehind(one, ground[0]) : ground[0];
  const [r, g, b, a] = parts(written);
  const strength = a * opacity * Number(inDrawing ? style.fillOpacity : 1);
  if (strength < 0.01) continue; // meant not to be seen
  const got = ratio(over([r, g, b, strength], under), under);
  const px = parseFloat(style.fontSize);
  const large = px >= 24 || (px >= 18.66 && Number(style.fontWeight) >= 700);
  if (got < (large ? 3 : 4.5)) found.add(`contrast ${got.toFixed(2)}: ${said(one)}`);
}
return [...found];
"""


FOCUS = r"""
const found = [];
const before = document.activeElement;
for (const one of document.querySelectorAll(`${reachable}, summary, [tabindex]`)) {
  if (!one.checkVisibility({ visibilityProperty: true }) || one.matches(':disabled')) continue;
  one.focus({ preventScroll: true });
  if (document.activeElement !== one) continue;
  const marked = [one, one.parentElement].some((each) => {
    const { outlineStyle, outlineWidth, boxShadow } = getComputedStyle(each);
    return outlineStyle === 'auto'
      || (outlineStyle !== 'none' && parseFloat(outlineWidth) >= 1.5) || boxShadow !== 'none';
  });
  if (!marked) found.push(`focus is not seen: ${said(one)}`);
}
before?.focus?.({ preventScroll: true });
return found;
"""
"""What does not show that it has the focus."""


def unmarked(tab: Browser) -> list[str]:
    """What can have the focus and does not show it to those who work by keys."""
    for kind in ("keyDown", "keyUp"):  # focus is drawn for them alone
        tab.call(
            "Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9
        )
    return _asked(tab, FOCUS)


def _asked(tab: Browser, script: str) -> list[str]:
    found: list[str] = tab.evaluate(f"(() => {{ {SHARED} {script} }})()")
    return found


def nameless(tab: Browser) -> list[str]:
    """Controls, pictures and regions without a name for screen readers."""
    found = []
    nodes = {node["nodeId"]: node for node in tab.call("Accessibility.getFullAXTree")["nodes"]}

    def role_of(node: dict[str, Any]) -> str:
        return str(node.get("role", {}).get("value", ""))

    for node in nodes.values():
        role = role_of(node)
        if node.get("ignored") or role not in NAMED:
            continue
        holder = nodes.get(node.get("parentId", ""), {})
        if role in ("image", "img") and role_of(holder) in SPEAK_FOR_PICTURES:
            continue
        if not str(node.get("name", {}).get("value", "")).strip():
            number = node["backendDOMNodeId"]
            described = tab.call("DOM.describeNode", backendNodeId=number)["node"]
            attributes = " ".join(described.get("attributes", []))[:80]
            found.append(f"{role} without a name: {described['localName']} {attributes}")
    return found


def faults(
    tab: Browser,
    *,
    widths: tuple[int, ...] = (WIDE, PHONE),
    schemes: tuple[str, ...] = SCHEMES,
    settled: str = SETTLED,
) -> list[str]:
    """What keeps people from using the page that is open, in sentences; empty if nothing does.

    The page is seen at each width and in each scheme, and is left at the last of them.

    Parameters
    ----------
    tab : Browser
        With the page open and drawn.
    widths : tuple of int
        Of the window, in CSS pixels.
    schemes : tuple of str
        Of "light" and "dark".
    settled : str
        A promise that is awaited after each change.
    """
    found = [*_asked(tab, STRUCTURE), *nameless(tab)]
    for width in widths:
        tab.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=HEIGHT,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        for scheme in schemes:
            feature = {"name": "prefers-color-scheme", "value": scheme}
            tab.call("Emulation.setEmulatedMedia", features=[feature])
            tab.evaluate(settled)
            found += [f"{width} px, {scheme}: {said}" for said in _asked(tab, CONTRAST)]
            found += [f"{width} px, {scheme}: {said}" for said in unmarked(tab)]
        found += [f"{width} px: {said}" for said in _asked(tab, LAYOUT)]
    return found
