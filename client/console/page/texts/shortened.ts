const SPACES = /[\t\n\v\f\r\u2028\u2029]+/g;
/** Signs that are not seen: controls, and those that turn the direction of the text after them. */
const UNSEEN = /[\u0000-\u001f\u007f-\u009f\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;

/** In one line, and with a mark for each sign that is not seen but changes what stands beside it. */
export const visible = (text: string): string => text.replace(SPACES, " ").replace(UNSEEN, "\ufffd");

/** What others wrote may be of any length, and contain anything. */
export const shortened = (text: string, length = 200): string =>
  visible(text.length <= length ? text : `${text.slice(0, length)}…`);

/** A name that others gave, where there is room for a line. */
export const shownName = (name: string): string => shortened(name, 80);
