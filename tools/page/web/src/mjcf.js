// Reads the MJCF text of the emulated robot (tools/plant/mjcf.cpp): the bodies with their joints and
// primitives, and the ground. The page draws what the physics collides with, and nothing has to be
// said twice.

const numbers = (text) => (text ?? "").trim().split(/\s+/).filter(Boolean).map(Number);

function geomOf(element) {
  return {
    name: element.getAttribute("name") ?? "",
    role: element.getAttribute("class") ?? "",
    type: element.getAttribute("type") ?? "sphere",
    size: numbers(element.getAttribute("size")),
    pos: numbers(element.getAttribute("pos") ?? "0 0 0"),
    euler: numbers(element.getAttribute("euler") ?? "0 0 0"),
    fromto: numbers(element.getAttribute("fromto")),
  };
}

const childrenNamed = (element, tag) => [...element.children].filter((c) => c.tagName === tag);

function bodyOf(element) {
  const joint = childrenNamed(element, "joint")[0];
  return {
    name: element.getAttribute("name") ?? "",
    pos: numbers(element.getAttribute("pos") ?? "0 0 0"),
    joint: joint && { name: joint.getAttribute("name"), axis: numbers(joint.getAttribute("axis")) },
    geoms: childrenNamed(element, "geom").map(geomOf),
    children: childrenNamed(element, "body").map(bodyOf),
  };
}

/** {ground: geoms, robot: body}. Throws with the parser's words when the text is no XML. */
export function parseMjcf(text) {
  const xml = new DOMParser().parseFromString(text, "application/xml");
  const broken = xml.querySelector("parsererror");
  if (broken) throw new Error(`the robot's shape cannot be read: ${broken.textContent}`);
  const world = xml.querySelector("worldbody");
  return {
    ground: childrenNamed(world, "geom").map(geomOf),
    robot: childrenNamed(world, "body").map(bodyOf)[0],
  };
}
