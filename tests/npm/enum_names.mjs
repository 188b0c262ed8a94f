// Which names a viewer shows for the numbers of a field. Reads a complete ros2msg definition on standard input, parses
// it with the parser that Foxglove and Lichtblick use, and prints {TYPE: {FIELD: {NUMBER: NAME}}} as JSON.
// The rule is theirs too (their enumValuesByDatatypeAndField): constants are names of the next field, of the same type.

import { text } from "node:stream/consumers";

import { parse } from "@foxglove/rosmsg";

const names = {};
for (const { name: type, definitions } of parse(await text(process.stdin), { ros2: true })) {
  let constants = {};
  let before;
  for (const { type: kind, name, isConstant, value } of definitions) {
    if (kind !== before) constants = {};
    before = kind;
    if (isConstant) {
      constants[value] = value in constants ? "<multiple constants match>" : name;
      continue;
    }
    if (Object.keys(constants).length) (names[type ?? ""] ??= {})[name] = constants;
    constants = {};
  }
}
process.stdout.write(JSON.stringify(names));
