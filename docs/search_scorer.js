// Results of the search by relevance. Sphinx itself gives every page that has a word the same score, and sorts by title.
const asked = (new URLSearchParams(window.location.search).get("q") || "").toLowerCase().match(/[^\W\d_]{2,}/g) || [];

// How much a page is about what was asked, from 0 to 1: the mean weight of the words, in any of their forms.
function aboutness(page) {
  const weights = Object.entries((typeof SEARCH_RANKS === "undefined" ? {} : SEARCH_RANKS)[page] || {});
  const found = asked.map((word) => {
    const stem = word.length > 4 ? word.replace(/(ies|es|s|y)$/, "") : word;
    return Math.max(0, ...weights.filter(([other]) => other.startsWith(stem)).map(([, weight]) => weight));
  });
  return found.reduce((sum, weight) => sum + weight, 0) / Math.max(1, found.length);
}

// Where most readers do not want to begin.
const LATER = /^(changelog|contributing|architecture|recipes|paper|lecture\/|gallery|genindex|reference\/errors)/;

var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
  score: ([page, title, anchor, description, score, file, kind]) => {
    if (kind === "object" || kind === "index") {
      // The functions and classes at the top of the package come before those of its rooms.
      return score + 4 - 2 * title.split(".").length + (title.split(".").at(-1) === asked.join("_") ? 12 : 0);
    }
    return score + 15 * aboutness(page) - (LATER.test(page) ? 8 : 0) + (kind === "title" && !anchor ? 5 : 0);
  },
};
