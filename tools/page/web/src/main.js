// One bundle for both: the live page starts by itself, a report calls sansoPage.replay.
import { live } from "./live.js";
import { replay } from "./replay.js";

window.sansoPage = { replay };
if (document.getElementById("live"))
  live().catch((error) => {
    document.getElementById("link").textContent = error.message;
    document.getElementById("link").classList.add("bad");
  });
