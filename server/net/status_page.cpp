// SPDX-License-Identifier: Apache-2.0
#include "server/net/status_page.h"

namespace seaway::server {

const std::string_view status_html = R"html(<!doctype html>
<html lang="en" data-state="loading">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Seaway</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/status.css">
<script src="/status.js" defer></script>
<header><h1>Seaway</h1><p id="says" role="status">asks the server ...</p></header>
<form id="door" hidden>
  <label>This server wants a token <input id="token" type="password" autocomplete="off"></label>
  <button>Show</button>
</form>
<main id="all" hidden>
  <figure>
    <canvas id="map" width="256" height="256" role="img" aria-label="Heights of the sea"></canvas>
    <figcaption id="caption"></figcaption>
  </figure>
  <section><h2>Sea</h2><table id="sea"></table></section>
  <section><h2>Server</h2><table id="server"></table></section>
  <section class="wide"><h2>What is computed</h2><p id="plan_says"></p><table id="plan"></table></section>
</main>
<footer><a href="/v1/state">state</a> <a href="/v1/plan">plan</a> <a href="/metrics">metrics</a>
<a href="/healthz">health</a> <a href="/readyz">readiness</a></footer>
</html>
)html";

const std::string_view status_style = R"css(
:root { color-scheme: light dark; --ink: #14232e; --soft: #5b6c78; --paper: #f7f9fa; --line: #d5dde2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4ecf1; --soft: #93a5b1; --paper: #10181e; --line: #2b3a45; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1rem; max-width: 64rem; color: var(--ink); background: var(--paper);
  font: 15px/1.45 system-ui, sans-serif; }
header { display: flex; flex-wrap: wrap; align-items: baseline; gap: 0 1rem; }
h1 { font-size: 1.4rem; margin: 0; } h2 { font-size: 1rem; margin: 0 0 .4rem; }
#says { margin: 0; color: var(--soft); }
html[data-state="lost"] #says { color: #c0392b; font-weight: 600; }
html[data-state="lost"] main { opacity: .5; }
main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(20rem, 100%), 1fr)); gap: 1.5rem; margin: 1rem 0; }
main[hidden], form[hidden] { display: none; }
figure { margin: 0; } section { min-width: 0; overflow-x: auto; } .wide { grid-column: 1 / -1; }
canvas { display: block; width: 100%; max-width: 28rem; aspect-ratio: 1; border: 1px solid var(--line); }
figcaption, #plan_says { color: var(--soft); font-size: .9rem; margin: .3rem 0; }
table { border-collapse: collapse; width: 100%; }
td, th { padding: .15rem .6rem .15rem 0; border-bottom: 1px solid var(--line); text-align: left; font-weight: 400;
  overflow-wrap: anywhere; }
th { color: var(--soft); white-space: nowrap; } .number { text-align: right; font-variant-numeric: tabular-nums; }
form { margin: 1rem 0; } footer { color: var(--soft); } footer a { margin-right: .6rem; color: inherit; }
)css";

const std::string_view status_script = R"js("use strict";
const side = 128, map_side_m_max = 4000, pause_ms = 1000, retry_ms = 5000;
const at = id => document.getElementById(id);
let token = "", entered = "", taken = false, wake = () => {}, before = null, sea = null;

class Refused extends Error { constructor(status, text) { super(text); this.status = status; } }

function get(path, headers) {
  return fetch(path, {headers, cache: "no-store", signal: AbortSignal.timeout(10000)});
}

async function ask(path) {
  if (/[^\x00-\xff]/.test(token)) throw new Refused(401, "no header carries it");
  const answer = await get(path, token ? {Authorization: "Bearer " + token} : {});
  if (!answer.ok) throw new Refused(answer.status, (await answer.text()).trim());
  return answer;
}

function number(value, digits) {
  return typeof value === "number" && isFinite(value) ? value.toFixed(digits) : "-";
}

// Rows of texts; a text of digits stands to the right. Nothing of the server's is read as HTML.
function fill(table, rows, head) {
  table.replaceChildren(...[...(head ? [head] : []), ...rows].map((cells, i) => {
    const row = document.createElement("tr");
    row.append(...cells.map((text, column) => {
      const cell = document.createElement(head && i === 0 || column === 0 ? "th" : "td");
      cell.textContent = text;
      const isHead = head && i === 0;
      if (column > 0 && (isHead || /^[-\d]/.test(text))) cell.className = "number";
      return cell;
    }));
    return row;
  }));
}

function readMetrics(text) {
  const sums = {};
  for (const line of text.split("\n")) {
    const found = /^(\w+)(?:\{[^}]*\})? (\S+)$/.exec(line);
    if (found) sums[found[1]] = (sums[found[1]] || 0) + Number(found[2]);
  }
  return {at_ms: performance.now(), sums};
}

function showSea(state) {
  const {requested: wish, realised: is} = state;
  fill(at("sea"), [
    ["Height Hs", number(is.hs_m, 2) + " m", number(wish.hs_m, 2) + " m"],
    ["Peak period Tp", number(is.tp_s, 1) + " s", number(wish.tp_s, 1) + " s"],
    ["Mean period Tz", number(is.tz_s, 1) + " s", number(wish.tz_s, 1) + " s"],
    ["Comes from", number(is.mean_from_deg, 0) + "\u00b0", number(wish.mean_from_deg, 0) + "\u00b0"],
    ["Heights within", number(state.height_error_m, 3) + " m", ""],
    ["Sea time", number(state.sea_time_s, 1) + " s", "epoch " + state.epoch],
    ["Changes", state.glides_until_s === null ? "none under way" : "from Hs " + number(state.realised_before.hs_m, 2) + " m until " + number(state.glides_until_s, 1) + " s",
      state.pace === 1 ? "" : "pace " + number(state.pace, 2)],
    ["Scene", state.scene, ""]], ["", "realised", "requested"]);
}

function showServer(metrics, device) {
  const {sums} = metrics;
  const passed_s = before ? (metrics.at_ms - before.at_ms) / 1000 : 0;
  const rate = (name, by, digits) => passed_s > 0
    ? number(Math.max(0, sums[name] - before.sums[name]) / by / passed_s, digits) : "-";
  fill(at("server"), [
    ["Sessions", number(sums.seaway_net_sessions, 0) + " of " + number(sums.seaway_net_sessions_max, 0)],
    ["Subscriptions", number(sums.seaway_net_subscriptions, 0)],
    ["Connections", number(sums.seaway_net_connections, 0)],
    ["Sent", rate("seaway_net_sent_bytes_total", 1e6, 3) + " MB/s"],
    ["Messages sent", rate("seaway_net_messages_sent_total", 1, 1) + " /s"],
    ["Keyframes computed", rate("seaway_keyframes_total", 1, 1) + " /s"],
    ["Questions", rate("seaway_questions_total", 1, 1) + " /s"],
    ["Memory", number(sums.process_resident_memory_bytes / 1e6, 0) + " MB"],
    ["Processor", rate("process_cpu_seconds_total", 0.01, 0) + " % of a core"],
    ["Device", device]]);
  before = metrics;
}

function showPlan(plan) {
  at("plan_says").textContent = plan.cascades.every(cascade => !cascade.fields.length) ? "Nobody subscribes: what is computed is what is asked for, as this picture." : "";
  const rows = plan.cascades.flatMap((cascade, i) => cascade.effects.map(effect => [
    "cascade " + i + ", " + number(cascade.length_m, 0) + " m", effect.effect,
    number(cascade.keyframes_per_s, 1), number(effect.share_us_per_keyframe, 0),
    number(effect.share_us_per_keyframe * cascade.keyframes_per_s, 0)]));
  fill(at("plan"), rows, rows.length
    ? ["", "effect", "keyframes a second", "\u00b5s a keyframe", "\u00b5s a second"] : undefined);
}

// From trough to crest; the middle is the mean sea.
const colours = [[8, 29, 66], [38, 110, 150], [240, 248, 250]];
function colour(share) {
  const place = Math.min(Math.max(share, 0), 1) * 2, low = place < 1 ? 0 : 1;
  return colours[low].map((c, i) => c + (colours[low + 1][i] - c) * (place - low));
}

async function showMap(state) {
  const longest_m = Math.max(...state.cascades.map(cascade => cascade.length_m));
  const side_m = Math.min(longest_m, map_side_m_max);
  const answer = await ask(`/v1/map?width_m=${side_m}&height_m=${side_m}&columns=${side}&rows=${side}`);
  const bytes = new DataView(await answer.arrayBuffer());
  const header_bytes = 64, canvas = at("map");
  const heights = new Float32Array(side * side);
  for (let i = 0; i < heights.length; ++i) heights[i] = bytes.getFloat32(header_bytes + 4 * i, true);
  const lowest = Math.min(...heights), highest = Math.max(...heights);
  const highest_hs_m = Math.max(state.realised.hs_m, state.realised_before ? state.realised_before.hs_m : 0);
  const reach_m = Math.max(0.8 * highest_hs_m, 1e-3); // a calm sea is flat, not noise
  canvas.width = canvas.height = side;
  const context = canvas.getContext("2d"), picture = context.createImageData(side, side);
  for (let y = 0; y < side; ++y)
    for (let x = 0; x < side; ++x) // row 0 of a map is the southernmost
      picture.data.set([...colour(0.5 + heights[(side - 1 - y) * side + x] / (2 * reach_m)), 255], 4 * (y * side + x));
  context.putImageData(picture, 0, 0);
  const t_s = Number(bytes.getBigInt64(56, true)) / 1e6;
  Object.assign(canvas.dataset, {lowestM: lowest, highestM: highest, sideM: side_m, tS: t_s, reachM: reach_m,
    southWestM: heights[0], northEastM: heights[side * side - 1],
    pictures: Number(canvas.dataset.pictures || 0) + 1});
  at("caption").textContent = `${number(side_m, 0)} m of sea, north up, at ${number(t_s, 1)} s: ` +
    `heights from ${number(lowest, 2)} to ${number(highest, 2)} m`;
}

function tell(state, words) {
  document.documentElement.dataset.state = state;
  at("says").textContent = words;
}

async function look() {
  if (document.visibilityState === "hidden") return pause_ms; // nobody looks: nothing is asked
  if (entered) [token, entered, taken] = [entered, "", false];
  try {
    const health = await get("/healthz", {});
    if (!health.ok) {
      tell("lost", "Out of order: " + (await health.text()).trim());
      return retry_ms;
    }
    const state = await (await ask("/v1/state")).json();
    const plan = await (await ask("/v1/plan")).json();
    const metrics = readMetrics(await (await ask("/metrics")).text());
    at("door").hidden = true;
    at("all").hidden = false;
    showSea(state);
    showServer(metrics, state.device);
    showPlan(plan);
    await showMap(state).catch(problem => {
      if (!(problem instanceof Refused && problem.status === 503) && problem.name !== "TimeoutError") throw problem;
      at("caption").textContent = `no picture now: ${problem.message}`; // others have the places of maps
    });
    taken = token !== "";
    tell("live", "The sea runs.");
    return pause_ms;
  } catch (problem) {
    if (problem instanceof Refused && problem.status === 401) {
      at("door").hidden = false;
      at("all").hidden = true;
      tell("token", taken ? "That is no longer the token." : token ? "That was not the token." : "");
      [token, taken] = ["", false];
      return 0;
    }
    tell("lost", problem instanceof Refused ? problem.message : "The server does not answer.");
    return retry_ms;
  }
}

// One look after another, whatever is entered meanwhile.
async function run() {
  for (;;) {
    const wait_ms = await look();
    if (!entered) await new Promise(done => {
      wake = done;
      if (wait_ms > 0) setTimeout(done, wait_ms);
    });
  }
}

at("door").addEventListener("submit", event => {
  event.preventDefault();
  entered = at("token").value.trim();
  at("token").value = "";
  if (entered) wake();
});
run();
)js";

} // namespace seaway::server
