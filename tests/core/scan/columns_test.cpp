#include "scan/columns.h"

#include <fmt/format.h>

#include "base/file.h"
#include "scan/scan.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

TEST(Columns, NamesAreUniqueAndFitFiles) {
  std::set<std::string_view> names{"x", "y", "z"};
  std::set<char> keys;
  for (const Column& column : kColumns) {
    EXPECT_TRUE(names.insert(column.name).second) << column.name;
    EXPECT_EQ(column.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"), std::string_view::npos)
        << column.name;
    EXPECT_FALSE(column.meaning.empty());
    EXPECT_EQ(kColumns[columnIndex(column.name)].name, column.name);
    EXPECT_TRUE(column.display.key == 0 || keys.insert(column.display.key).second) << column.name;
  }
  EXPECT_EQ(columnIndex("near_ir"), kColumnCount);
}

// Integers have no NaN, are never rounded and are told as whole numbers. Points without a value are told from values
// with limits, and from those that a lossy format rounds.
TEST(Columns, RowsAreConsistent) {
  for (const Column& column : kColumns) {
    const bool integer = column.type != ColumnType::Float32;
    EXPECT_TRUE((!integer && column.validity != ColumnValidity::Finite) || std::isfinite(column.none)) << column.name;
    EXPECT_TRUE(!integer || column.loss == ColumnLoss::Exact) << column.name;
    const bool limited = column.validity == ColumnValidity::Interval || column.validity == ColumnValidity::SensorRange;
    EXPECT_TRUE(integer || std::isnan(column.none) || (!limited && column.loss != ColumnLoss::Bounded)) << column.name;
    EXPECT_EQ(column.loss == ColumnLoss::Bounded, column.lossBound > 0) << column.name;
    EXPECT_EQ(column.validity == ColumnValidity::Interval, column.low < column.high) << column.name;
    EXPECT_TRUE(!column.display.scaleOfValidity || column.validity == ColumnValidity::Interval) << column.name;
  }
}

TEST(Columns, KeysHaveTheTypesOfTheirRows) {
  forEachColumn([]<class Key>(Key key) {
    EXPECT_EQ(sizeof(typename Key::Value), bytesOf(key.row.type));
    EXPECT_EQ(std::is_floating_point_v<typename Key::Value>, key.row.type == ColumnType::Float32);
    EXPECT_EQ(&key.row, &kColumns[key.index]);
  });
}

TEST(ColumnSet, IsASet) {
  EXPECT_TRUE(ColumnSet().names().empty());
  EXPECT_EQ(ColumnSet::all().names().size(), kColumnCount);
  constexpr ColumnSet set(kTime, kLabel);
  EXPECT_EQ(set.names(), (std::vector<std::string>{"label", "time"})) << "in the order of the table";
  EXPECT_TRUE(set.has(kTime) && !set.has(kRing));
  EXPECT_EQ(set.without(kTime), ColumnSet(kLabel));
  EXPECT_EQ(set.with(kRing).with(kRing), ColumnSet(kLabel, kTime, kRing));
  EXPECT_EQ(ColumnSet(kLabel, kIncidence).channels(), Channel::Semantic | Channel::Incidence);
  EXPECT_EQ(ColumnSet(kRing, kTime).channels(), Channels());
  for (std::size_t i = 0; i < kColumnCount; ++i) EXPECT_EQ(ColumnSet::byDefault().has(i), kColumns[i].byDefault);
}

TEST(Columns, ValuesAreToldInUnitsForPeople) {
  EXPECT_EQ(displayText(kTime.row, 0.0125), "12.5000 ms");
  EXPECT_EQ(displayText(kIncidence.row, kPi / 4), "45.000 deg");
  EXPECT_EQ(displayText(kRing.row, 63), "63");
  EXPECT_EQ(displayText(kIntensity.row, 0.5), "0.5");
}

// The schema of the manifest names all columns.
TEST(Columns, AreInTheSchema) {
  const std::string schema = readFile(SCANMILL_SOURCE_DIR "/docs/manifest.schema.json");
  std::string names;
  for (const std::string& name : scanColumnNames(ColumnSet::all())) {
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name);
  }
  EXPECT_THAT(schema, HasSubstr("\"enum\": [" + names + "]"));
}

}  // namespace
}  // namespace scanmill
