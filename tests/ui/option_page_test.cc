#include "ui/option_page.h"

#include <QSpinBox>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Nothing is rounded or cut off on its way through the widgets.
TEST(OptionPage, ShowingAndHidingChangesNothing) {
  for (const char* quality : {"low", "medium", "high", "extreme"}) {
    StructNerfOptions options;
    options.reconstruction = QualityPreset(quality);
    const auto table = MakeOptionTable(&options);
    std::vector<OptionValue> values;
    for (const OptionEntry& entry : table) {
      values.push_back(entry.Value());
    }
    OptionPage page(table, nullptr);
    page.show();
    page.hide();
    for (size_t i = 0; i < table.size(); ++i) {
      EXPECT_TRUE(table[i].Value() == values[i]) << OptionText(table[i]);
    }
  }
}

TEST(OptionPage, HasARowForEveryOption) {
  StructNerfOptions options;
  const auto table = MakeOptionTable(&options);
  const OptionPage page(table, nullptr);
  for (const OptionEntry& entry : table) {
    const std::string label = entry.name.substr(entry.name.find('.') + 1);
    const auto* widget =
        page.findChild<QWidget*>(QString::fromStdString(label));
    ASSERT_NE(widget, nullptr) << label;
    EXPECT_EQ(widget->toolTip().toStdString(), entry.help);
  }
}

TEST(OptionPage, ValuesAreWrittenWhenThePageGoes) {
  StructNerfOptions options;
  OptionPage page(MakeOptionTable(&options), nullptr);
  page.show();
  page.findChild<QSpinBox*>("num_steps")->setValue(123);
  page.hide();
  EXPECT_EQ(options.reconstruction.training.num_steps, 123);
}

}  // namespace
}  // namespace structnerf
