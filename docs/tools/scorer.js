/* Order of what a search finds: titles, then exact names of the API, then words of pages, then names that only hold the word. */
var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 4,
  objPrio: { 0: -3, 1: -3, 2: -3 },
  objPrioDefault: -3,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
