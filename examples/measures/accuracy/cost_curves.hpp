#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// Costs of many cases, counted: by what kind of pair it is (stratum), by what is asked of the answer, by
// coverage and by cost. Verdicts are made of these counts alone, so that whoever holds them, a program or a
// page, finds the same. Costs are rounded up and coverage down to grids: what is found for a choice on the
// grids is exact, for others it errs to the safe side.

namespace touchstone::measures {

// ---- what is asked beside the class and the separation

inline constexpr std::size_t kAskedNormals = 1, kAskedPoints = 2;  ///< bits
inline constexpr std::size_t kAskedKinds = 4;                      ///< combinations of the two
/// Of these some are the same question: overlap has one.
constexpr std::size_t asked_kinds(QueryKind kind) { return kind == QueryKind::overlap ? 1 : kAskedKinds; }

inline constexpr const char* kNoValue = "no value";

/// The cost of one case for one part of an answer.
struct CaseCost {
  double cost = 0;          ///< [m]; NaN: unsupported
  const char* reason = "";  ///< of kCostReasons
  bool missing = false;     ///< the class is right, a figure that was asked for is not there
};
/// Every reason, so that files can name them by their place.
inline constexpr std::array<const char*, 12> kCostReasons = {
    "",      "missed contact", "phantom contact", "undecided",      "failed",        kNoValue,
    "depth", "distance",       "normal",          "witness points", "deepest point", "contact points"};

// ---- strata

/// A contact is deep where its depth is more than this share of the larger solid's size (its largest
/// diagonal); up to it, and at 0, it is touching. 1 % of 1 m is beyond what resting or gripping sinks in.
inline constexpr double kDeepOverSize = 0.01;

enum class Band : std::uint8_t { apart, touching, deep };

/// Upper ends of the bins of distances of pairs that are apart, and of their largest |world coordinate| [m];
/// a last bin holds what is beyond.
inline constexpr std::array<double, 9> kApartBins = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100};
inline constexpr std::array<double, 8> kWithinBins = {1, 10, 100, 1e3, 1e4, 1e5, 1e6, 1e7};

/// The first bin whose end is at least `value`; the last, open one is bins.size().
std::size_t bin_of(double value, std::span<const double> bins);

struct Stratum {
  Band band = Band::apart;
  std::size_t apart_bin = 0;  ///< 0 unless apart
  std::size_t within_bin = 0;
  auto operator<=>(const Stratum&) const = default;
};
/// @param contact the exact class; @param size of the larger solid, @param largest_coordinate [m].
Stratum stratum_of(double separation, bool contact, double size, double largest_coordinate);

// ---- costs and coverage on their grids

/// Codes count two-digit decimals upward: 0 is no cost, 1 to 90 are 1.0e-18 to 9.9e-18 m, and so on up to
/// kLastCode, which stands for all that is more.
inline constexpr std::uint32_t kCodesADecade = 90, kLastCode = 30 * kCodesADecade + 1;
/// Code c is the decimal MeE, M = 10 + (c - 1) % kCodesADecade, E = kFirstExponent + (c - 1) / kCodesADecade.
inline constexpr int kFirstExponent = -19;
/// The least code whose value is not below the cost. @pre cost >= 0
std::uint32_t code_of_cost(double cost);
/// [m]; +inf of kLastCode.
double cost_of_code(std::uint32_t code);

/// Coverage is counted by the last of these that it reaches; the first, 0, always is.
inline constexpr std::array<double, 10> kCoverageBins = {0,   0.25, 0.5,  0.75, 0.8,
                                                         0.9, 0.95, 0.98, 0.99, 0.999};
std::size_t coverage_bin(double coverage);

// ---- the counts

/// Of one stratum and one thing asked.
struct AskedCosts {
  /// counts[coverage bin][code]; cases that are unsupported are not in it.
  std::map<std::size_t, std::map<std::uint32_t, std::size_t>> counts;
  std::size_t missing = 0;
  std::uint32_t worst_code = 0;
  std::size_t worst_index = 0;   ///< the case; of equal costs the first
  std::size_t worst_reason = 0;  ///< place in kCostReasons
  bool operator==(const AskedCosts&) const = default;
};

struct StratumCosts {
  Stratum stratum;
  std::size_t cases = 0, missed = 0, phantom = 0, undecided = 0, failed = 0, unsupported = 0;
  std::array<AskedCosts, kAskedKinds> asked;  ///< asked_kinds() of them
  bool operator==(const StratumCosts&) const = default;
};

/// One backend's answers to one query on one set; strata in order, those without cases left out.
using CostCurves = std::vector<StratumCosts>;

/// One case.
struct CurveCase {
  Stratum stratum;
  PairStatus status = PairStatus::failed;
  bool contact = false;
  std::size_t index = 0;
  std::array<CaseCost, kAskedKinds> costs;
  double coverage = 1;
};

class CurveBuilder {
 public:
  explicit CurveBuilder(QueryKind kind) : asked_kinds_(measures::asked_kinds(kind)) {}
  void add(const CurveCase& each);
  CostCurves take();

 private:
  std::size_t asked_kinds_;
  std::map<Stratum, StratumCosts> strata_;
};

// ---- as text

/// The counts as numbers, each in digits of five bits, the least first, of the alphabet A-Z a-z 0-9 + /, 32
/// added to every digit but a number's last. A list of strata, each: band, apart bin, within bin, cases,
/// missed, phantom, undecided, failed, unsupported; then for each thing asked: missing, worst code, worst
/// case, worst reason, how many coverage bins (0: those of the thing asked before), and for each of these the
/// bin, how many codes, and of each code its difference from the one before (from 0) and its count.
std::string text_of(const CostCurves& curves, QueryKind kind);
/// @throws InputError for what text_of() did not write.
CostCurves curves_from(const std::string& text, QueryKind kind);

}  // namespace touchstone::measures
