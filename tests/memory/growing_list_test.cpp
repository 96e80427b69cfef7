#include "touchstone/contact_core/memory/growing_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>
#include <set>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/prctl.h>
#include <sys/resource.h>
#endif

#include "touchstone/contact_core/memory/record_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {
namespace {

constexpr bool kMapsMemory =
#ifdef __linux__
    TOUCHSTONE_SANITIZED == 0;
#else
    false;
#endif

using Row = std::array<std::uint32_t, 24>;  // as large as a pose

Row row_of(std::uint32_t value) {
  Row out;
  out.fill(value);
  return out;
}

void change(Random& random, std::uint32_t value, GrowingList<Row>& list, std::vector<Row>& as_vector) {
  // The same change of both.
  const auto place = static_cast<std::ptrdiff_t>(random.below(static_cast<int>(list.size()) + 1));
  switch (random.below(9)) {
    case 0: {
      const std::size_t count = static_cast<std::size_t>(random.below(6000));
      list.resize(count, row_of(value)), as_vector.resize(count, row_of(value));
      return;
    }
    case 1:
      list.assign(100, row_of(value)), as_vector.assign(100, row_of(value));
      return;
    case 2:
      list.insert(list.begin() + place, row_of(value));
      as_vector.insert(as_vector.begin() + place, row_of(value));
      return;
    case 3: {
      const std::vector<Row> rows(static_cast<std::size_t>(random.below(3000)), row_of(value));
      list.insert(list.begin() + place, rows.begin(), rows.end());
      as_vector.insert(as_vector.begin() + place, rows.begin(), rows.end());
      return;
    }
    case 4:
      if (place == static_cast<std::ptrdiff_t>(list.size())) return;
      list.erase(list.begin() + place), as_vector.erase(as_vector.begin() + place);
      return;
    case 5:
      if (list.empty()) return;
      for (int i = 0; i < 4000; ++i) list.push_back(list[0]), as_vector.push_back(as_vector[0]);
      return;
    case 6: {
      GrowingList<Row> other;
      if (random.below(2) == 0) other.resize(7);
      other = std::move(list);
      list.swap(other);
      return;
    }
    case 7: {
      GrowingList<Row> other(std::move(list));
      EXPECT_TRUE(list.empty() && list.capacity() == 0);
      list = std::move(other);
      return;
    }
    default:
      list.reserve(static_cast<std::size_t>(random.below(20000)));
  }
}

// Up to megabytes, so that they are on the heap, go to pages of their own, and grow there.
TEST(GrowingList, HoldsWhatAVectorHolds) {
  Random random(1);
  for (int run = 0; run < 20; ++run) {
    GrowingList<Row> list;
    std::vector<Row> as_vector;
    for (std::uint32_t i = 0; i < 40; ++i) {
      change(random, i, list, as_vector);
      ASSERT_EQ(list.size(), as_vector.size());
      ASSERT_TRUE(std::equal(list.begin(), list.end(), as_vector.begin()));
      ASSERT_LE(list.size(), list.capacity());
    }
  }
}

TEST(GrowingList, IsAssignedAValueOfItsOwn) {
  GrowingList<Row> list;
  list.assign(10, row_of(7));
  list.assign(500, list[0]);
  EXPECT_EQ(list.size(), 500u);
  EXPECT_EQ(std::count(list.begin(), list.end(), row_of(7)), 500);
}

// Their bytes would be few, modulo the largest size.
TEST(GrowingList, MoreElementsThanMemoryCountsAreRefused) {
  const std::size_t too_many = PTRDIFF_MAX / sizeof(Row) + 1;
  for (const std::size_t count : {too_many, 2 * too_many, SIZE_MAX / sizeof(Row) + 2, SIZE_MAX}) {
    GrowingList<Row> list;
    list.push_back(row_of(1));
    EXPECT_THROW(list.reserve(count), std::bad_alloc);
    EXPECT_THROW(list.resize(count), std::bad_alloc);
    EXPECT_THROW(resize_more(list, count), std::bad_alloc);
    EXPECT_EQ(list.size(), 1u);
    EXPECT_EQ(list[0], row_of(1));
  }
}

struct CopiesItself {
  CopiesItself(const CopiesItself&) {}
};
struct IsLookedAt : CopiesItself {
  using MovesByBits = IsLookedAt;
};
struct IsDerived : IsLookedAt {};

static_assert(kMovesByBits<Row> && kMovesByBits<std::pair<int, Row>> && kMovesByBits<IsLookedAt>);
static_assert(kMovesByBits<std::pair<IsLookedAt, int>>);
static_assert(!kMovesByBits<CopiesItself> && !kMovesByBits<IsDerived> && !kMovesByBits<std::vector<int>>);
static_assert(!kMovesByBits<std::pair<int, CopiesItself>>);

TEST(RecordList, RecordsStayWhereverMemoryEnds) {
  for (std::size_t after = 0; after < 2; ++after) {
    RecordList<Row, 4> list;
    for (std::uint32_t i = 0; i < 4; ++i) list.emplace_back(row_of(i));
    {
      const FailingAllocation failing(after);
      EXPECT_THROW(list.emplace_back(row_of(4)), std::bad_alloc);
    }
    EXPECT_EQ(list.size(), 4u);
    list.emplace_back(row_of(4));
    const Row* const first = &list[4];
    for (std::uint32_t i = 5; i < 8; ++i) list.emplace_back(row_of(i));
    EXPECT_EQ(first, &list[4]);
    for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(list[i], row_of(i));
  }
}

struct alignas(64) Line {
  std::array<char, 64> bytes;
};

TEST(GrowingList, AlignsItsElements) {
  std::array<GrowingList<Line>, 8> lists;
  for (int i = 0; i < 12; ++i)
    for (GrowingList<Line>& list : lists) {
      list.reserve(std::size_t{1} << i);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(list.data()) % 64, 0u);
    }
}

TEST(GrowingList, CallsOperatorNewWhereverItGrows) {
  GrowingList<Row> list;
  for (int i = 0; i < 40000; ++i) {
    const std::size_t capacity = list.capacity(), before = allocation_count();
    list.emplace_back();
    EXPECT_EQ(allocation_count() > before, list.capacity() > capacity);
  }
}

#ifdef __linux__

long page_faults() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

/// With huge ones a copy takes as few new pages as none does.
struct SmallPages {
  bool were_off = prctl(PR_GET_THP_DISABLE, 0, 0, 0, 0) == 1;
  bool are_all = prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0) == 0;
  ~SmallPages() { prctl(PR_SET_THP_DISABLE, were_off ? 1 : 0, 0, 0, 0); }
};

TEST(GrowingList, GrowsWithoutNewPages) {
  if (!kMapsMemory) GTEST_SKIP() << "under a sanitizer lists are on the heap";
  const SmallPages pages;
  if (!pages.are_all) GTEST_SKIP() << "huge pages cannot be turned off";
  GrowingList<Row> list;
  list.resize(100000);  // 2 400 pages
  const long before = page_faults();
  list.reserve(200000);
  EXPECT_LE(page_faults() - before, 16);
}

#endif

TEST(GrowingList, ListsComeToNewPagesInTurn) {
  if (!kMapsMemory) GTEST_SKIP() << "lists are on the heap";
  constexpr std::size_t kLists = 64;
  std::array<GrowingList<double>, kLists> lists;
  std::set<std::uintptr_t> places;
  for (GrowingList<double>& list : lists) {
    list.reserve(GrowingMemory::kMapped);
    places.insert(reinterpret_cast<std::uintptr_t>(list.data()) % 4096);
  }
  EXPECT_EQ(places.size(), kLists);
}

TEST(ReserveMore, ListsTakeTurnsToGrow) {
  constexpr std::size_t kLists = 128, kCount = 1000;
  std::array<std::vector<int>, kLists> lists;
  for (std::vector<int>& list : lists) reserve_more(list, kCount);
  std::size_t grown = 0, most = 0;
  for (std::size_t count = kCount + 1; count <= 2 * kCount + 1; ++count) {
    std::size_t now = 0;
    for (std::vector<int>& list : lists) {
      const std::size_t capacity = list.capacity();
      reserve_more(list, count);
      now += list.capacity() > capacity;
      ASSERT_GE(list.capacity(), count);
    }
    EXPECT_TRUE(now == 0 || 2 * count > 3 * kCount) << count;
    grown += now, most = std::max(most, now);
  }
  EXPECT_EQ(grown, kLists);
  EXPECT_LE(most, 2u);
}

}  // namespace
}  // namespace touchstone
