import type { ComponentChildren } from "preact";

interface Column {
  name: string;
  /** Of its cells: "number", "free-text". */
  kind?: string;
}

interface Row {
  key: string;
  cells: readonly ComponentChildren[];
}

interface Props {
  label: string;
  columns: readonly Column[];
  /** Which column names the row. */
  head?: number;
  rows: readonly Row[];
}

/**
 * A table that is a list of cards where there is no room for columns: each cell then has its column's
 * name beside it. Its roles are written out, for browsers forget them of what is no longer drawn as a table.
 */
export function DataTable({ label, columns, head = 0, rows }: Props) {
  return (
    <div class="table-frame">
      <table class="data" role="table" aria-label={label}>
        <thead role="rowgroup">
          <tr role="row">
            {columns.map(({ name, kind }) => (
              <th key={name} scope="col" role="columnheader" class={kind}>
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody role="rowgroup">
          {rows.map(({ key, cells }) => (
            <tr key={key} role="row">
              {cells.map((cell, i) =>
                i === head ? (
                  <th key={i} scope="row" role="rowheader">
                    {cell}
                  </th>
                ) : (
                  <td key={i} role="cell" class={columns[i]!.kind} data-name={columns[i]!.name}>
                    {cell}
                  </td>
                ),
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
