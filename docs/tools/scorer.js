/* Order of search results: titles, exact names of the API, words of pages, names that only contain the word. */
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
