// What the server told last, by name, and the rooms that follow it.
export const told = {
  state: null, work: null, jobs: [], results: [], choices: null, forms: [],
};
const following = new Map();

export function follow(name, act) {
  following.set(name, [...(following.get(name) ?? []), act]);
}

export function tell(name, value) {
  const before = told[name];
  told[name] = value;
  for (const act of following.get(name) ?? []) act(value, before);
}

// The rooms show again what holds, after an edit that was refused.
export function again(name) {
  if (told[name] !== null) tell(name, told[name]);
}
