#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"
#include "touchstone/examples/measures/paths/path_truth.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::comparison {

/// One set of a corpus: a pair file, and a file with the truth of its cases.
struct CorpusSet {
  std::string name;
  std::string description;
  std::string pairs, truth;  ///< files, relative to the corpus
  std::size_t cases = 0;
  std::string pairs_sha256, truth_sha256;  ///< 64 hexadecimal digits
  // Of sets of paths (path_set.hpp): poses a path, and the file with the truth about the paths.
  std::size_t poses = 1;
  std::string impacts, impacts_sha256;

  bool is_paths() const { return poses > 1; }
};

/// A frozen collection of pairs with the truth about them (examples/bench/README.md): the contents of its
/// manifest.
struct Corpus {
  std::string folder;
  std::string name, version;
  std::string sha256;  ///< of the manifest, so of all that it names
  std::vector<CorpusSet> sets;
};
inline constexpr const char* kCorpusManifest = "corpus.json";
inline constexpr const char* kCorpusSchema = "touchstone.corpus/1";

/// Reads the folder's manifest and holds every file against its hash.
/// @throws InputError naming the file that is missing, changed or of another format.
Corpus load_corpus(const std::string& folder);

/// The pairs of a set of the corpus, under the set's name.
/// @throws InputError naming the file: unreadable, a case that is no pair, another number of cases.
PairSet corpus_pairs(const Corpus& corpus, const CorpusSet& set);

/// The class and the separation of every case, as the corpus has them: normals are not in it.
std::vector<PairTruth> corpus_truth(const Corpus& corpus, const CorpusSet& set);

/// Compares `exact`'s answers here with the corpus, bit by bit.
/// @throws InputError naming the first case in which the two differ.
void check_truth(const Corpus& corpus, const CorpusSet& set, std::span<const PairTruth> truth);

/// The truth about the paths of a set of paths.
std::vector<PathTruth> corpus_impacts(const Corpus& corpus, const CorpusSet& set);
/// As check_truth(). @param pairs the set's.
void check_impacts(const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                   std::span<const PathTruth> truth);
/// The text of the file with the truth about paths: what corpus_impacts() reads back bit for bit.
std::string impacts_text(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth);

/// The truth file's text: what corpus_truth() reads back bit for bit.
std::string truth_text(const PairSet& set, std::span<const PairTruth> truth);

}  // namespace touchstone::comparison
