/** What others wrote may be of any length. */
export const shortened = (text: string, length = 200): string =>
  text.length <= length ? text : `${text.slice(0, length)}…`;
