/**
 * Whether a configuration that the program sends is one that this page reported itself, and has since replaced.
 *
 * The program sends every page what was reported last, its own report included. A page that took the older ones would
 * jerk back under the hand that drags it; one that took none would keep a configuration that another page, whose report
 * arrived in between, knows nothing of.
 *
 * @param source who reported it, a space, and a number that grows
 * @param mine who this page is
 * @param newest number of its newest report
 * @param plays whether a motion goes on here, which its own reports are not to stop
 */
export function isOutdated(source: string, mine: string, newest: number, plays: boolean = false) {
  const [who, number] = source.split(" ");
  return who === mine && (plays || Number(number) < newest);
}
