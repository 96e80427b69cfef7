#include "touchstone/examples/measures/accuracy/cost_curves.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::measures {
namespace {

// The double nearest to the decimal, as every reader of "13e-7" gets it.
double two_digits(std::uint32_t code) {
  const std::string text = std::to_string(10 + (code - 1) % kCodesADecade) + "e" +
                           std::to_string(kFirstExponent + static_cast<int>((code - 1) / kCodesADecade));
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::vector<double> make_values() {
  std::vector<double> values = {0.0};
  for (std::uint32_t code = 1; code < kLastCode; ++code) values.push_back(two_digits(code));
  values.push_back(kInfinity);
  return values;
}

const std::vector<double>& code_values() {
  static const std::vector<double> values = make_values();
  return values;
}

std::size_t reason_index(std::string_view reason) {
  const auto found = std::find(kCostReasons.begin(), kCostReasons.end(), reason);
  return found == kCostReasons.end() ? 0 : static_cast<std::size_t>(found - kCostReasons.begin());
}

void note(AskedCosts& asked, const CurveCase& each, const CaseCost& cost) {
  const std::uint32_t code = code_of_cost(cost.cost);
  ++asked.counts[coverage_bin(each.coverage)][code];
  asked.missing += cost.missing;
  if (code <= asked.worst_code) return;
  asked.worst_code = code;
  asked.worst_index = each.index;
  asked.worst_reason = reason_index(cost.reason);
}

// ---- text

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

void put(std::string& text, std::size_t value) {
  for (; value >= 32; value /= 32) text += kDigits[32 + value % 32];
  text += kDigits[value];
}

class Numbers {
 public:
  explicit Numbers(const std::string& text) : text_(text) {}
  bool done() const { return at_ == text_.size(); }
  std::size_t next() {
    std::size_t value = 0, factor = 1;
    for (;;) {
      const std::size_t digit = at_ < text_.size() ? kDigits.find(text_[at_++]) : std::string::npos;
      // 2^50 cases are more than any run has.
      if (digit == std::string::npos || factor > (std::size_t{1} << 50))
        throw InputError("curves: not readable");
      value += digit % 32 * factor;
      if (digit < 32) return value;
      factor *= 32;
    }
  }
  // A number that is to be below `limit`.
  std::size_t next_below(std::size_t limit) {
    const std::size_t value = next();
    if (value >= limit) throw InputError("curves: a number is beyond its range");
    return value;
  }

 private:
  const std::string& text_;
  std::size_t at_ = 0;
};

void put(std::string& text, const AskedCosts& asked, const AskedCosts* before) {
  for (const std::size_t value :
       {asked.missing, std::size_t{asked.worst_code}, asked.worst_index, asked.worst_reason})
    put(text, value);
  if (before != nullptr && before->counts == asked.counts) return put(text, 0);
  put(text, asked.counts.size());
  for (const auto& [bin, codes] : asked.counts) {
    put(text, bin);
    put(text, codes.size());
    std::size_t last = 0;
    for (const auto& [code, count] : codes) {
      put(text, code - last);
      put(text, count);
      last = code;
    }
  }
}

AskedCosts next_asked(Numbers& numbers, const AskedCosts* before) {
  AskedCosts asked;
  asked.missing = numbers.next();
  asked.worst_code = static_cast<std::uint32_t>(numbers.next_below(kLastCode + 1));
  asked.worst_index = numbers.next();
  asked.worst_reason = numbers.next_below(kCostReasons.size());
  const std::size_t bins = numbers.next_below(kCoverageBins.size() + 1);
  if (bins == 0 && before != nullptr) asked.counts = before->counts;
  for (std::size_t b = 0; b < bins; ++b) {
    auto& codes = asked.counts[numbers.next_below(kCoverageBins.size())];
    std::size_t code = 0;
    for (std::size_t left = numbers.next(); left > 0; --left) {
      code += numbers.next_below(kLastCode + 1 - code);
      codes[static_cast<std::uint32_t>(code)] = numbers.next();
    }
  }
  return asked;
}

}  // namespace

std::size_t bin_of(double value, std::span<const double> bins) {
  return static_cast<std::size_t>(std::lower_bound(bins.begin(), bins.end(), value) - bins.begin());
}

Stratum stratum_of(double separation, bool contact, double size, double largest_coordinate) {
  Stratum stratum;
  stratum.within_bin = bin_of(largest_coordinate, kWithinBins);
  if (contact)
    stratum.band = -separation > kDeepOverSize * size ? Band::deep : Band::touching;
  else
    stratum.apart_bin = bin_of(separation, kApartBins);
  return stratum;
}

std::uint32_t code_of_cost(double cost) {
  const std::vector<double>& values = code_values();
  return static_cast<std::uint32_t>(std::lower_bound(values.begin(), values.end(), cost) - values.begin());
}

double cost_of_code(std::uint32_t code) { return code_values()[code]; }

std::size_t coverage_bin(double coverage) {
  const auto above = std::upper_bound(kCoverageBins.begin() + 1, kCoverageBins.end(), coverage);
  return static_cast<std::size_t>(above - kCoverageBins.begin()) - 1;
}

void CurveBuilder::add(const CurveCase& each) {
  StratumCosts& costs = strata_[each.stratum];
  costs.stratum = each.stratum;
  ++costs.cases;
  if (each.status == PairStatus::unsupported) {
    ++costs.unsupported;
    return;
  }
  costs.missed += each.status == PairStatus::separated && each.contact;
  costs.phantom += each.status == PairStatus::overlapping && !each.contact;
  costs.undecided += each.status == PairStatus::undecided;
  costs.failed += each.status == PairStatus::failed;
  for (std::size_t asked = 0; asked < asked_kinds_; ++asked)
    note(costs.asked[asked], each, each.costs[asked]);
}

CostCurves CurveBuilder::take() {
  CostCurves curves;
  for (auto& [stratum, costs] : strata_) curves.push_back(std::move(costs));
  strata_.clear();
  return curves;
}

std::string text_of(const CostCurves& curves, QueryKind kind) {
  std::string text;
  for (const StratumCosts& each : curves) {
    for (const std::size_t value :
         {static_cast<std::size_t>(each.stratum.band), each.stratum.apart_bin, each.stratum.within_bin,
          each.cases, each.missed, each.phantom, each.undecided, each.failed, each.unsupported})
      put(text, value);
    for (std::size_t a = 0; a < asked_kinds(kind); ++a)
      put(text, each.asked[a], a > 0 ? &each.asked[a - 1] : nullptr);
  }
  return text;
}

CostCurves curves_from(const std::string& text, QueryKind kind) {
  CostCurves curves;
  for (Numbers numbers(text); !numbers.done();) {
    StratumCosts& each = curves.emplace_back();
    each.stratum.band = static_cast<Band>(numbers.next_below(3));
    each.stratum.apart_bin = numbers.next_below(kApartBins.size() + 1);
    each.stratum.within_bin = numbers.next_below(kWithinBins.size() + 1);
    for (std::size_t* value :
         {&each.cases, &each.missed, &each.phantom, &each.undecided, &each.failed, &each.unsupported})
      *value = numbers.next();
    for (std::size_t a = 0; a < asked_kinds(kind); ++a)
      each.asked[a] = next_asked(numbers, a > 0 ? &each.asked[a - 1] : nullptr);
  }
  return curves;
}

}  // namespace touchstone::measures
