#include <gtest/gtest.h>

#include <modsearch/problem/markup.hpp>

namespace modsearch {
namespace {

TEST(Markup, EscapesWhatWouldBeMarkup) { EXPECT_EQ(markup_safe("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;"); }

// XML 1.0, section 3.3.3: in an attribute a tab or a line break as such is read as a space, a reference to it is not.
TEST(Markup, RefersToTabsAndLineBreaksByTheirNumbers) { EXPECT_EQ(markup_safe("a\tb\nc\rd"), "a&#9;b&#10;c&#13;d"); }

// XML 1.0, section 2.2: no other character below U+0020, nor U+FFFE and U+FFFF, may stand in a document, and a
// reference to one is no better.
TEST(Markup, ReplacesWhatNoMarkupCanHold) {
  EXPECT_EQ(markup_safe("a\ab"),
            "a\xEF\xBF\xBD"
            "b");
  EXPECT_EQ(markup_safe(std::string_view{"a\0b", 3}),
            "a\xEF\xBF\xBD"
            "b");
  EXPECT_EQ(markup_safe("\xEF\xBF\xBF."), "\xEF\xBF\xBD.");
}

TEST(Markup, NamesTheFirstCharacterThatItCannotHold) {
  EXPECT_EQ(not_in_markup("a\ab\x1F"), "U+0007");
  EXPECT_EQ(not_in_markup("a\x1F"), "U+001F");
  EXPECT_EQ(not_in_markup("\xEF\xBF\xBE"), "U+FFFE");
  EXPECT_EQ(not_in_markup("tab\t, line\n, \xC3\xA4, \x7F"), std::nullopt);
}

}  // namespace
}  // namespace modsearch
