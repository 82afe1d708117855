import type { ComponentChildren } from "preact";
import { go } from "./route.ts";

interface Props {
  to: string;
  class?: string;
  current?: boolean;
  children: ComponentChildren;
}

/** A link to a view, which does not load the page again. */
export function Link({ to, current, children, ...rest }: Props) {
  const onClick = (event: MouseEvent): void => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    go(to);
  };
  return (
    <a href={to} onClick={onClick} {...(current ? { "aria-current": "page" } : {})} {...rest}>
      {children}
    </a>
  );
}
