"""Uses galleries in headless Chromium as people do: search, filters, keyboard, turntables, comparison, ten thousand assets.

Arguments: the program, the folder that gallery.sh made, and where screenshots go ("": nowhere). Nothing may be asked of a
network, no script may fail, and a page of ten thousand assets must be there within two seconds.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

from playwright.sync_api import sync_playwright

KILN, WORK, SHOTS = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
MANY = 10_000
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


def many(pictures):
    """A folder as a batch of ten thousand assets leaves it; its pictures are links to a few real ones."""
    folder = WORK / "many"
    names = ["chair", "椅子", "стул", "table \"oak\" & co", "lamp #5", "sofa"]
    lines = []
    for k in range(MANY):
        name = f"room {k % 40:02}/{names[k % len(names)]} {k}.glb"
        picture = f"{name}.png"
        failed = k % 97 == 5
        if not failed:
            (folder / picture).parent.mkdir(parents=True, exist_ok=True)
            os.link(pictures[k % len(pictures)], folder / picture)
        error = 0.5 + (k * 7919 % 1000) / 250
        stages = {"import": 0.01 * (k % 7), "prepare": 0.02, "kdtree": 0.03, "render": 0.2 + k % 31, "write": 0.01, "total": 0.3 + k % 31}
        lines.append(json.dumps({
            "kiln": "0.1.0", "input": name, "content": f"blake3:{k:064x}", "settings": "blake3:11", "seed": 0,
            "status": "failed" if failed else "warned" if k % 11 == 0 else "ok",
            "error_code": "invalid" if failed else None, "error_message": f"{name}: byte 8: the header lies" if failed else None,
            "light": "studio", "warnings": [{"code": "missing-texture", "place": f"/images/{k % 9}", "message": "is not there"}] if k % 11 == 0 else [],
            "outputs": [] if failed else [{"path": picture, "format": "png", "view": 0, "width": 96, "height": 96, "spp": 64,
                "samples": 64, "exposure": 0, "error": error, "error_bound": error * 1.05, "relmse": 0.004, "relmse_bound": 0.005,
                "target_met": None, "bias": []}],
            "scene": {"triangles": 100 + k * 37, "instances": 1, "emitters": 3, "effects": ["textures", "normal-maps"]},
            "seconds": stages, "cpu_seconds": stages, "rays": {"camera": 1, "bounce": 2, "shadow": 3}, "nonfinite": 0,
            "peak_bytes": 104857600}, ensure_ascii=False))
    folder.mkdir(exist_ok=True)
    (folder / "manifest.jsonl").write_text("\n".join(lines) + "\n{\"input\": \"half a li", encoding="utf-8")
    began = time.monotonic()
    subprocess.run([KILN, "gallery", str(folder), "--quiet"], check=True)
    print(f"kiln gallery of {MANY} assets: {time.monotonic() - began:.2f} s, {(folder / 'index.html').stat().st_size / 1e6:.1f} MB")
    return folder


class Visit:
    """A page, with everything that went wrong on it."""

    def __init__(self, browser, **options):
        self.context = browser.new_context(**{"viewport": {"width": 1360, "height": 900}, **options})
        self.page = self.context.new_page()
        self.wrong = []
        self.asked = []
        self.page.on("pageerror", lambda e: self.wrong.append(f"script: {e}"))
        self.page.on("console", lambda m: m.type == "error" and self.wrong.append(m.text))
        self.page.on("request", lambda r: self.asked.append(r.url))

    def open(self, folder, hash=""):
        began = time.monotonic()
        self.page.goto((folder / "index.html").as_uri() + hash)
        self.page.wait_for_selector("html[data-ready]")
        self.page.wait_for_function("() => document.querySelector('.card.loaded') || document.querySelector('#nothing:not([hidden])')")
        return time.monotonic() - began

    def shot(self, name):
        if SHOTS:
            pathlib.Path(SHOTS).mkdir(parents=True, exist_ok=True)
            self.page.wait_for_timeout(350)
            self.page.screenshot(path=f"{SHOTS}/{name}.png")

    def names(self):
        """Assets on the page in their order."""
        return self.page.eval_on_selector_all(".card", "cards => cards.map(c => c.querySelector('bdi').textContent)")

    def focused(self):
        return self.page.evaluate("document.activeElement.querySelector('bdi')?.textContent ?? document.activeElement.id")

    def wait_for_focus(self, name):
        """That the focus comes to an asset: it comes back from a dialog when the dialog is gone."""
        self.page.wait_for_function("name => document.activeElement.querySelector?.('bdi')?.textContent == name", arg=name)

    def close(self):
        assert not self.wrong, self.wrong
        beyond = [url for url in self.asked if not url.startswith(("file:", "data:"))]
        assert not beyond, beyond
        width = self.page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert width <= 0, f"{width} pixels wider than the window"
        self.context.close()


def every_name_is_shown(browser):
    visit = Visit(browser)
    page = visit.page
    visit.open(WORK / "now")
    inputs = [json.loads(line)["input"] for line in (WORK / "now/manifest.jsonl").read_text(encoding="utf-8").splitlines()]
    assert len(inputs) == 9, inputs
    shown = page.eval_on_selector_all(".card a", "links => links.map(a => a.title)")
    assert shown == [*inputs, "warned.obj"], shown
    page.wait_for_function("() => document.querySelectorAll('.card.loaded').length == 9")
    blank = page.eval_on_selector_all(".card.blank .instead", "texts => texts.map(t => t.textContent)")
    assert len(blank) == 1 and "no face is sound" in blank[0], blank
    assert page.locator("#count").text_content() == "10 assets"
    visit.shot("gallery-light")
    visit.close()


def search_filters_and_sorting(browser):
    visit = Visit(browser)
    page = visit.page
    visit.open(WORK / "now")
    page.keyboard.press("/")
    assert visit.focused() == "search"
    page.keyboard.type("СТУЛ")
    assert visit.names() == ["стул № 1.obj"]
    assert page.locator("#count").text_content() == "1 of 10 assets"
    page.fill("#search", "no such thing")
    assert page.locator("#nothing").is_visible()
    page.click("#clear")
    page.click(".status.failed")
    assert visit.names() == ["broken.obj"]
    assert "status=failed" in page.url
    page.click(".status.failed")
    page.click("summary:has-text('Format')")
    visit.shot("gallery-filter")
    page.click(".menu label:has-text('gltf')")
    assert visit.names() == ["frosted_dice.gltf"]
    page.reload()
    page.wait_for_selector("html[data-ready]")
    assert visit.names() == ["frosted_dice.gltf"], "the address keeps the choice"
    page.evaluate("location.hash = ''")
    page.wait_for_function("() => document.querySelectorAll('.card').length == 10")
    page.select_option("#sort", "triangles")
    first = visit.names()[0]
    page.click("#direction")
    assert visit.names()[0] != first
    page.select_option("#sort", "difference")
    assert page.locator(".card .figure").first.text_content().startswith("differs by"), "the largest difference comes first"
    visit.close()


def keyboard_alone(browser):
    visit = Visit(browser)
    page = visit.page
    visit.open(WORK / "now")
    names = visit.names()
    page.focus("#theme")
    page.keyboard.press("Tab")
    assert visit.focused() == names[0], "the wall is one stop of the tab key"
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert visit.focused() == names[2]
    page.keyboard.press("End")
    assert visit.focused() == names[-1]
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    assert page.locator("#details-name").text_content() == names[1]
    page.keyboard.press("ArrowRight")
    assert page.locator("#details-name").text_content() == names[2]
    page.keyboard.press("Escape")
    visit.wait_for_focus(names[2])
    assert not page.locator("dialog").is_visible()
    unnamed = page.evaluate("""[...document.querySelectorAll('button, input, select, a')]
        .filter(e => !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).map(e => e.outerHTML)""")
    assert not unnamed, unnamed
    visit.close()


def turntables_turn(browser):
    visit = Visit(browser)
    page = visit.page
    visit.open(WORK / "now")
    stage = page.locator(".card.turns .stage").first
    box = stage.bounding_box()
    source = lambda: stage.locator("img").get_attribute("src")
    still = source()
    page.mouse.move(box["x"] + 5, box["y"] + 50)
    page.mouse.move(box["x"] + 5 + box["width"] / 2, box["y"] + 50, steps=4)
    page.wait_for_function("src => document.querySelector('.card.turns img').getAttribute('src') != src", arg=still)
    page.wait_for_function("() => document.querySelector('.card.turns img').getAttribute('src').includes('.003.png')")
    page.mouse.move(5, 5)
    page.wait_for_function("src => document.querySelector('.card.turns img').getAttribute('src') == src", arg=still)
    visit.close()


def one_asset_in_full(browser):
    visit = Visit(browser)
    page = visit.page
    visit.open(WORK / "now", "#asset=furniture%2Fcornell_box.glb")
    dialog = page.locator("dialog")
    text = dialog.inner_text()
    for word in ["levels of 255", "with 95 % confidence", "kd-tree", "Triangles", "8 per pixel", "differs by"]:
        assert word in text, (word, text)
    slider = page.locator(".turner input")
    slider.fill("4")
    page.wait_for_function("() => document.querySelector('.easel .now').src.includes('.004.png')")
    wipe = page.locator(".wipe")
    wipe.focus()
    before = page.evaluate("document.querySelector('.easel').style.getPropertyValue('--wipe')")
    page.keyboard.press("ArrowRight")
    assert before != page.evaluate("document.querySelector('.easel').style.getPropertyValue('--wipe')")
    visit.shot("asset-light")
    page.click("button:has-text('Difference')")
    visit.shot("asset-difference")
    loaded = page.eval_on_selector_all(".easel img", "pictures => pictures.map(p => p.naturalWidth)")
    assert loaded == [96, 96], loaded
    page.click("button:has-text('Slider')")
    page.keyboard.press("Escape")
    page.evaluate("location.hash = '#asset=broken.obj'")
    assert "no face is sound" in page.locator("dialog .message").inner_text()
    visit.shot("asset-failed")
    visit.close()


def dark_and_narrow(browser):
    for scheme, width, height in [("dark", 1360, 900), ("light", 390, 844), ("dark", 390, 844)]:
        visit = Visit(browser, color_scheme=scheme, viewport={"width": width, "height": height})
        visit.open(WORK / "now")
        ink = visit.page.evaluate("getComputedStyle(document.body).color.match(/\\d+/g).slice(0, 3).reduce((s, n) => s + Number(n), 0)")
        assert (ink > 384) == (scheme == "dark"), ink
        visit.shot(f"gallery-{scheme}-{width}")
        visit.page.evaluate("location.hash = '#asset=furniture%2Ffrosted_dice.gltf'")
        visit.shot(f"asset-{scheme}-{width}")
        wide = visit.page.evaluate("document.querySelector('dialog').scrollWidth <= document.documentElement.clientWidth + 1")
        assert wide
        visit.page.keyboard.press("Escape")
        visit.close()


def ten_thousand(browser, folder):
    # The first visit warms the browser and the disk; a person's second is the same.
    times = []
    for _ in range(3):
        visit = Visit(browser)
        times.append(visit.open(folder))
        if len(times) < 3:
            visit.close()
    print("ten thousand assets open in", ", ".join(f"{t:.2f} s" for t in times))
    assert min(times) < 2, times
    page = visit.page
    assert page.locator("#count").text_content() == "10,000 assets"
    assert page.locator("#notice").is_visible(), "half a line is told"
    cards = lambda: page.locator(".card").count()
    assert cards() < 200, cards()
    visit.shot("many-top")
    page.evaluate("scrollTo(0, document.documentElement.scrollHeight / 2)")
    page.wait_for_function("() => Number(document.querySelector('.card:nth-child(20)').getAttribute('aria-posinset')) > 3000")
    assert cards() < 200, cards()
    page.wait_for_function("() => document.querySelectorAll('.card.loaded').length > 10")
    visit.shot("many-middle")
    page.focus("#theme")
    page.keyboard.press("Tab")
    page.keyboard.press("End")
    assert visit.focused().endswith(" 9999.glb")
    search = page.evaluate("""() => { const began = performance.now(); const input = document.getElementById('search');
        input.value = 'lamp 99'; input.dispatchEvent(new Event('input')); return performance.now() - began; }""")
    print(f"a search takes {search:.0f} ms")
    assert search < 500, search
    assert page.locator("#count").text_content().split()[1] == "of"
    page.fill("#search", "")
    page.click("summary:has-text('Warnings')")
    page.click(".menu label:has-text('missing-texture')")
    page.select_option("#sort", "error")
    visit.shot("many-filtered")
    visit.close()


def main():
    pictures = sorted((WORK / "now").rglob("*.000.png"))
    folder = many(pictures)
    with sync_playwright() as playwright:
        # Without the sandbox, for whoever tests in a container.
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        for step in [every_name_is_shown, search_filters_and_sorting, keyboard_alone, turntables_turn, one_asset_in_full, dark_and_narrow]:
            step(browser)
            print("gallery:", step.__name__.replace("_", " "))
        ten_thousand(browser, folder)
        print("gallery: ten thousand")
        browser.close()


main()
