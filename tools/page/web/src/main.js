// One bundle for all: the live page starts by itself, a report calls sansoPage.replay (a session)
// or sansoPage.mechanism (a diagnosis).
import { live } from "./live.js";
import { mechanism } from "./mechanism.js";
import { replay } from "./replay.js";

window.sansoPage = { mechanism, replay };
if (document.getElementById("live"))
  live().catch((error) => {
    document.getElementById("link").textContent = error.message;
    document.getElementById("link").classList.add("bad");
  });
