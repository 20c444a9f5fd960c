#include "colmap_plugin/option_table.h"

#include "colmap_plugin/colmap_compat.h"

#include <cmath>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// Parses as the command does.
void Parse(std::vector<std::string> args, StructNerfOptions* options) {
  const auto table = MakeOptionTable(options);
  colmap::OptionManager manager;
  AddOptions(table, &manager);
  args.insert(args.begin(), "colmap");
  std::vector<char*> argv;
  for (std::string& arg : args) {
    argv.push_back(arg.data());
  }
  if (!ParseOptions(static_cast<int>(argv.size()), argv.data(), &manager)) {
    std::exit(EXIT_FAILURE);
  }
}

std::string CheckError(const StructNerfOptions& options) {
  try {
    CheckOptions(options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(OptionTable, NamesAreUniqueAndEveryOptionIsExplained) {
  StructNerfOptions options;
  std::set<std::string> names;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    EXPECT_THAT(entry.name, StartsWith("StructNeRF."));
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_FALSE(entry.help.empty()) << entry.name;
    EXPECT_LE(entry.min_value, entry.max_value) << entry.name;
  }
}

TEST(OptionTable, CheckpointMinutesHaveARange) {
  StructNerfOptions options;
  for (const double minutes : {-1.0, 1e7, std::nan("")}) {
    options.checkpoint_minutes = minutes;
    EXPECT_THAT(CheckError(options), HasSubstr("checkpoint_minutes"));
  }
  options.checkpoint_minutes = 0;
  EXPECT_EQ(CheckError(options), "");
}

TEST(OptionTable, MemoryIsAmountOrMinusOne) {
  StructNerfOptions options;
  for (const double amount : {-1.0, 1e-3, 1e6}) {
    options.max_memory_gb = amount;
    EXPECT_EQ(CheckError(options), "") << amount;
  }
  for (const double amount : {-5.0, 0.0, 1e30, HUGE_VAL, std::nan("")}) {
    options.max_memory_gb = amount;
    EXPECT_THAT(CheckError(options), HasSubstr("max_memory_gb")) << amount;
  }
}

TEST(OptionTable, AllPresetsAreInRange) {
  for (const std::string quality :
       {"low", "medium", "high", "extreme", "paper"}) {
    StructNerfOptions options;
    options.reconstruction = QualityPreset(quality);
    EXPECT_EQ(CheckError(options), "") << quality;
  }
}

TEST(OptionTable, ParsesEveryType) {
  StructNerfOptions options;
  options.reconstruction.training.seed = 5;
  Parse({"--StructNeRF.num_steps",
         "17",
         "--StructNeRF.patch_weight=0.25",
         "--StructNeRF.input_type",
         "photometric"},
        &options);
  EXPECT_EQ(options.reconstruction.training.num_steps, 17);
  EXPECT_EQ(options.reconstruction.loss.patch_weight, 0.25);
  EXPECT_EQ(options.input_type, "photometric");
  EXPECT_EQ(options.reconstruction.training.seed, 5);  // present value stays
}

TEST(OptionTableDeathTest, UnknownOrUnreadableOptionIsNamed) {
  StructNerfOptions options;
  EXPECT_EXIT(Parse({"--StructNeRF.no_such_option", "1"}, &options),
              testing::ExitedWithCode(EXIT_FAILURE),
              "StructNeRF.no_such_option");
  EXPECT_EXIT(Parse({"--StructNeRF.num_steps", "many"}, &options),
              testing::ExitedWithCode(EXIT_FAILURE),
              "StructNeRF.num_steps");
}

// These stop compiling when an option is added, removed or renamed: then the
// table needs the same.
TEST(OptionTable, HasEveryOptionOfTheMethod) {
  StructNerfOptions options;
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10] =
      options.reconstruction.field;
  auto& [s1, s2, s3, s4, s5, s6, s7, s8, s9] = options.reconstruction.sampling;
  auto& [l1,
         l2,
         l3,
         l4,
         l5,
         l6,
         l7,
         l8,
         l9,
         l10,
         l11,
         l12,
         l13,
         l14,
         l15,
         l16,
         l17,
         l18,
         l19,
         l20,
         l21,
         l22,
         l23] = options.reconstruction.loss;
  auto& [t1, t2, t3, t4, t5, t6, t7, t8, t9, t10, t11, t12] =
      options.reconstruction.training;
  auto& [p1, p2, p3, p4, p5, p6, p7] = options.reconstruction.stereo;
  auto& [e1, e2, e3, e4, e5, e6, e7] = options.reconstruction.extraction;
  std::set<const void*> fields = {
      &f1,  &f2,  &f3,  &f4,  &f5,  &f6,  &f7,  &f8,  &f9,  &f10, &s1,  &s2,
      &s3,  &s4,  &s5,  &s6,  &s7,  &s8,  &s9,  &l1,  &l2,  &l3,  &l4,  &l5,
      &l6,  &l7,  &l8,  &l9,  &l10, &l11, &l12, &l13, &l14, &l15, &l16, &l17,
      &l18, &l19, &l20, &l21, &l22, &l23, &t1,  &t2,  &t3,  &t4,  &t5,  &t6,
      &t7,  &t8,  &t9,  &t10, &t11, &t12, &p1,  &p2,  &p3,  &p4,  &p5,  &p6,
      &p7,  &e1,  &e2,  &e3,  &e4,  &e5,  &e6,  &e7};
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    std::visit([&](const auto* field) { fields.erase(field); }, entry.value);
  }
  EXPECT_THAT(fields, IsEmpty());
}

void SetNumber(const OptionEntry& entry, const double number) {
  if (int* const* integer = std::get_if<int*>(&entry.value)) {
    **integer = static_cast<int>(number);
  } else if (double* const* real = std::get_if<double*>(&entry.value)) {
    **real = number;
  }
}

TEST(OptionTable, RangesAreThoseOfTheMethod) {
  StructNerfOptions widest;
  widest.reconstruction.field.min_resolution = 2;
  widest.reconstruction.field.max_resolution = 65536;
  widest.reconstruction.stereo.window_step = 2;
  widest.reconstruction.stereo.window_radius = 5;
  widest.reconstruction.sampling.guide_by_prior = true;
  widest.reconstruction.field.type = "mlp";
  widest.prior_path = "maps";
  StructNerfOptions options = widest;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    if (entry.max_value == std::numeric_limits<double>::max()) {
      continue;
    }
    for (const double limit : {entry.min_value, entry.max_value}) {
      SetNumber(entry, limit);
      EXPECT_EQ(CheckError(options), "") << entry.name << " " << limit;
    }
    for (const double beyond : {entry.min_value - 1, entry.max_value + 1}) {
      SetNumber(entry, beyond);
      EXPECT_THAT(CheckError(options), HasSubstr(entry.name)) << beyond;
    }
    options = widest;
  }
}

TEST(OptionTable, WordsOfPresetsMustBeWrittenOut) {
  StructNerfOptions options;
  options.quality = "high";
  EXPECT_NO_THROW(CheckPresetWords(options, "structnerf", "high"));
  EXPECT_THROW(CheckPresetWords(options, "structnerf", "medium"),
               std::runtime_error);
  EXPECT_THROW(CheckPresetWords(options, "nerf", "high"), std::runtime_error);
}

TEST(OptionTable, NamesOptionOutOfRange) {
  StructNerfOptions options;
  options.reconstruction.training.num_steps = 0;
  EXPECT_THAT(CheckError(options),
              StartsWith("The option --StructNeRF.num_steps must be"));

  options = StructNerfOptions();
  options.reconstruction.loss.color_weight =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.color_weight"));

  options = StructNerfOptions();
  options.input_type = "both";
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.input_type"));
}

TEST(OptionTable, PriorsAreGivenWhereAndOnlyWhereTheyAreUsed) {
  StructNerfOptions options;
  options.prior_path = "maps";
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.prior_path"));
  options.reconstruction.loss.dense_prior_weight = 0.1;
  EXPECT_EQ(CheckError(options), "");
  options.prior_path.clear();
  EXPECT_THAT(CheckError(options), HasSubstr("prior_path is missing"));
  options.prior_path = "maps";
  options.prior_type = "both";
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.prior_type"));
}

TEST(OptionTable, TextIsThatOfAProjectFile) {
  StructNerfOptions options;
  options.max_memory_gb = 2.5;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    if (entry.name == "StructNeRF.max_memory_gb") {
      EXPECT_EQ(OptionText(entry), "StructNeRF.max_memory_gb = 2.5");
      EXPECT_EQ(std::get<double>(entry.Value()), 2.5);
    }
  }
}

}  // namespace
}  // namespace structnerf
