#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The status page in a Chromium, in front of the real server: what it shows is what the server says.

    test_status_page.py SEAWAY_SERVER CHROMIUM [FOLDER_FOR_SCREENSHOTS]
"""
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

import browser

SERVER, CHROMIUM = sys.argv[1:3]
PICTURES = sys.argv[3] if len(sys.argv) > 3 else None
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.append(os.path.join(ROOT, "tests/support"))
from served import Served  # noqa: E402

LIVE = "document.documentElement?.dataset.state === 'live'"
MAP = "document.getElementById('map')"


class Server(Served):
    def __init__(self, scene, *options):
        super().__init__(SERVER, scene, "--device", "native", *options, cwd=ROOT)
        self.page = f"http://127.0.0.1:{self.port}"

    def get(self, path, token=None):
        headers = {"Authorization": "Bearer " + token} if token else {}
        with urllib.request.urlopen(urllib.request.Request(self.page + path, headers=headers), timeout=60) as answer:
            return answer.read()

    def metric(self, name, token=None):
        lines = self.get("/metrics", token).decode().splitlines()
        return sum(float(line.split()[-1]) for line in lines if line.split("{")[0].split(" ")[0] == name)


class StatusPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = browser.Browser(CHROMIUM)
        cls.addClassCleanup(cls.browser.close)

    def serve(self, scene, *options):
        server = Server(scene, *options)
        self.addCleanup(server.stop)
        return server

    def keep(self, page, name):
        picture = page.picture()
        if PICTURES:
            with open(os.path.join(PICTURES, name + ".png"), "wb") as file:
                file.write(picture)

    def shown(self, page):
        return page.value(f"Object.assign({{}}, {MAP}.dataset)")

    def test_it_shows_the_heights_of_the_sea_that_the_server_has(self):
        server = self.serve("scenes/north_sea_gale.toml")
        page = self.browser.open(server.page + "/")
        page.wait_for(LIVE)
        page.wait_for(f"{MAP}.dataset.pictures >= 2")  # it goes on by itself
        # One instant of the page, and the same places and time asked of the server.
        seen = json.loads(page.value(f"""JSON.stringify({{data: {{...{MAP}.dataset}}, size: {MAP}.width,
            pixels: Array.from({MAP}.getContext('2d').getImageData(0, 0, {MAP}.width, {MAP}.height).data)}})"""))
        data, size = seen["data"], seen["size"]
        side_m = float(data["sideM"])
        raw = server.get(f"/v1/map?width_m={side_m}&height_m={side_m}&columns={size}&rows={size}&t_s={data['tS']}")
        heights = struct.unpack(f"<{size * size}f", raw[64:])
        within = 2 * struct.unpack_from("<f", raw, 20)[0]  # both maps are within the bound that they state
        self.assertAlmostEqual(float(data["lowestM"]), min(heights), delta=within)
        self.assertAlmostEqual(float(data["highestM"]), max(heights), delta=within)
        self.assertGreater(max(heights) - min(heights), 2, "it is a gale")
        # Colours grow lighter from trough to crest, north up: blue of the darkest is 66, of the lightest 250.
        self.assertEqual(len(seen["pixels"]), 4 * size * size)
        for row, column in ((0, 0), (0, size - 1), (size // 3, size // 2), (size - 1, 0), (size - 1, size - 1)):
            height = heights[(size - 1 - row) * size + column]
            share = min(max(0.5 + height / (2 * float(data["reachM"])), 0), 1) * 2
            blue = 66 + (150 - 66) * share if share < 1 else 150 + (250 - 150) * (share - 1)
            self.assertAlmostEqual(seen["pixels"][4 * (row * size + column) + 2], blue,
                                   delta=1 + 184 * within / (2 * float(data["reachM"])))
        state = json.loads(server.get("/v1/state"))
        text = page.value("document.body.innerText")
        self.assertIn(f"{state['realised']['hs_m']:.2f} m", text)
        self.assertIn("0 of 1024", text)
        self.assertIn("none under way", text)
        self.keep(page, "gale")
        self.assertEqual(page.complaints(), [])
        page.resize(380, 800)
        page.wait_for("document.documentElement.scrollWidth <= 380")
        self.keep(page, "gale_narrow")
        page.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        self.assertEqual(page.value("getComputedStyle(document.body).backgroundColor"), "rgb(16, 24, 30)")
        self.keep(page, "gale_dark")
        # Loaded again, and a second time beside it.
        page.ask("Page.reload")
        beside = self.browser.open(server.page + "/")
        for one in (page, beside):
            one.ask("Page.bringToFront")  # one that cannot be seen asks for nothing
            one.wait_for(LIVE)
        # Who cannot be seen asks for nothing; one picture may have been on its way.
        page.wait_for("document.visibilityState === 'hidden'")
        pictures = f"Number({MAP}.dataset.pictures)"
        hidden = page.value(pictures)
        beside.wait_for(f"{pictures} >= {beside.value(pictures) + 3}")
        self.assertLessEqual(page.value(pictures), hidden + 1)
        # Where nobody looks nothing is computed.
        for one in (page, beside):
            one.ask("Page.navigate", url="about:blank")
        until_s, before = time.monotonic() + 60, None
        while (computed := server.metric("seaway_keyframes_total")) != before:  # what was under way
            self.assertLess(time.monotonic(), until_s, "a page that goes on never rests for three seconds")
            before = computed
            time.sleep(3)

    def test_it_shows_who_is_there_and_what_is_computed_for_them(self):
        server = self.serve("scenes/calm.toml")
        page = self.browser.open(server.page + "/")
        page.wait_for(LIVE)
        self.assertIn("Nobody subscribes", page.value("document.getElementById('plan_says').textContent"))
        query = os.path.join(os.path.dirname(SERVER), "seaway-query")
        client = subprocess.Popen([query, server.url, "--local", "--at", "0,0", "--watch", "5"],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        table = """(id => Object.fromEntries(Array.from(document.querySelectorAll(`#${id} tr`)).map(
            row => Array.from(row.children, cell => cell.textContent.trim())).map(([name, ...rest]) => [name, rest])))"""
        page.wait_for(f"parseFloat({table}('server')['Keyframes computed'][0]) > 0")
        page.wait_for(f"{table}('server')['Sessions'][0] === '1 of 1024'")
        page.wait_for(f"parseFloat({table}('server')['Sent'][0]) > 0")
        # State, plan and counters are asked for one by one.
        page.wait_for(f"{table}('server')['Subscriptions'][0] === '1'")
        page.wait_for("document.querySelectorAll('#plan tr').length > 1")
        shown = json.loads(page.value(f"JSON.stringify({table}('server'))"))
        self.assertEqual(shown["Subscriptions"], ["1"])
        for name, (value, *_) in shown.items():
            self.assertNotIn("-", value.split()[0] if name != "Device" else "", f"{name}: {value}")
        # Each row: a cascade, an effect, how often, what it costs a keyframe and a second, rounded to what is shown.
        plan = json.loads(server.get("/v1/plan"))
        rows = json.loads(page.value("JSON.stringify(Array.from(document.querySelectorAll('#plan tr')).slice(1).map("
                                     "row => Array.from(row.children, cell => cell.textContent)))"))
        effects = [effect for cascade in plan["cascades"] for effect in cascade["effects"]]
        self.assertGreater(len(rows), 0)
        self.assertEqual([row[1] for row in rows], [effect["effect"] for effect in effects])
        for row in rows:
            self.assertGreater(float(row[2]), 0, row)
            self.assertGreater(float(row[3]), 0, row)
            self.assertAlmostEqual(float(row[4]), float(row[2]) * float(row[3]), delta=0.06 * float(row[3]) + float(row[2]), msg=row)
        self.assertEqual(page.complaints(), [])

    def test_a_picture_that_is_refused_leaves_the_rest_live(self):
        server = self.serve("scenes/calm.toml")
        page = self.browser.open(server.page + "/")
        page.wait_for(LIVE)
        page.value("""(() => { const ask = window.fetch; window.fetch = (path, options) =>
            path.startsWith('/v1/map') ? Promise.resolve(new Response('others have the places', {status: 503})) : ask(path, options); })()""")
        page.wait_for("document.getElementById('caption').textContent.includes('others have the places')")
        page.wait_for(LIVE)
        self.assertEqual(page.value("document.documentElement.dataset.state"), "live")

    def test_with_a_token_it_asks_for_it_and_shows_nothing_before(self):
        with tempfile.NamedTemporaryFile("w", suffix=".token") as file:
            file.write("open sesame\n")
            file.flush()
            server = self.serve("scenes/calm.toml", "--client-token-file", file.name)
            page = self.browser.open(server.page + "/")
            page.wait_for("document.documentElement?.dataset.state === 'token'")
            self.assertTrue(page.value("document.getElementById('all').hidden"))
            self.keep(page, "token")

            def enter(token):
                page.value(f"document.getElementById('token').value = '{token}';"
                           "document.querySelector('#door button').click()")

            page.value("""(() => { const ask = window.fetch; let now = 0; window.most = 0;
                window.fetch = async (...all) => { window.most = Math.max(window.most, ++now);
                    try { return await ask(...all); } finally { --now; } }; })()""")
            enter("guess")
            page.wait_for("document.getElementById('says').innerText.includes('not the token')")
            enter("\u043a\u043b\u044e\u0447")  # no header carries it
            page.wait_for("document.getElementById('token').value === ''")
            time.sleep(0.5)
            self.assertEqual(page.value("document.getElementById('says').innerText"), "That was not the token.")
            self.assertEqual(page.value("document.documentElement.dataset.state"), "token")
            for _ in range(3):  # by who is impatient
                enter("open sesame")
            page.wait_for(LIVE)
            page.wait_for("Number(document.getElementById('map').dataset.pictures) >= 3")
            self.assertEqual(page.value("window.most"), 1, "one look at a time")
            self.assertEqual(page.value("getComputedStyle(document.getElementById('door')).display"), "none")
            self.assertNotIn("sesame", page.value("location.href + document.documentElement.outerHTML"))
            self.assertEqual(page.value("localStorage.length + sessionStorage.length"), 0)
            self.assertEqual(page.value("document.cookie"), "")
            with open(file.name, "w") as changed:
                changed.write("open barley\n")
            server.process.send_signal(signal.SIGHUP)
            page.wait_for("document.documentElement.dataset.state === 'token'")
            self.assertEqual(page.value("document.getElementById('says').innerText"), "That is no longer the token.")
            enter("open barley")
            page.wait_for(LIVE)

    def test_what_the_server_says_is_text_whatever_it_looks_like(self):
        name = "<img src=x onerror=document.title='run'>.toml"
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, name)
            shutil.copy(os.path.join(ROOT, "scenes/calm.toml"), scene)
            server = self.serve(scene)
            page = self.browser.open(server.page + "/")
            page.wait_for(LIVE)
            self.assertIn(name, page.value("document.body.innerText"))
            self.assertEqual(page.value("document.querySelectorAll('img').length"), 0)
            self.assertNotEqual(page.value("document.title"), "run")
            self.assertEqual(page.complaints(), [])

    def test_a_calm_sea_is_shown_and_a_server_that_goes_is_told_of(self):
        server = self.serve("scenes/calm.toml")
        page = self.browser.open(server.page + "/")
        page.wait_for(LIVE)
        self.assertEqual(page.complaints(), [])
        self.assertIn("heights from", page.value("document.getElementById('caption').innerText"))
        self.keep(page, "calm")
        server.stop()
        page.wait_for("document.documentElement?.dataset.state === 'lost'")
        self.assertIn("does not answer", page.value("document.getElementById('says').innerText"))
        self.keep(page, "gone")

    def test_a_server_that_takes_connections_and_answers_nothing_is_told_of(self):
        server = self.serve("scenes/calm.toml")
        page = self.browser.open(server.page + "/")
        page.wait_for(LIVE)
        server.process.send_signal(signal.SIGSTOP)
        self.addCleanup(server.process.send_signal, signal.SIGCONT)  # before it is stopped
        page.wait_for("document.documentElement.dataset.state === 'lost'")
        self.assertEqual(page.value("document.getElementById('says').innerText"), "The server does not answer.")
        server.process.send_signal(signal.SIGCONT)
        page.wait_for(LIVE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
