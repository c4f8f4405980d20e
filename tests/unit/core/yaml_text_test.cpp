#include "kinetrace/core/yaml_text.hpp"

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

TEST(YamlText, OneDocumentHasNoSecond) {
  for (const char* text :
       {"", "a: 1", "---\na: 1\n", "%YAML 1.2\n# a comment\n---\na: 1\n", "a: 1\n...\n", "a: 1\n...\n# end\n\n",
        "...\na: 1\n", "a: ----\nb: --- c\n", "a:\n  ---\n", "----\n", "a: 1\r\n...\r\n"}) {
    EXPECT_EQ(second_document_line(text), std::nullopt) << text;
  }
}

TEST(YamlText, ASecondDocumentIsFoundWhereItBegins) {
  EXPECT_EQ(second_document_line("a: 1\n---\nb: 2\n"), 2);
  EXPECT_EQ(second_document_line("---\na: 1\n--- # next\nb: 2\n"), 3);
  EXPECT_EQ(second_document_line("---\n---\n"), 2);
  EXPECT_EQ(second_document_line("a: 1\r\n---\r\nb: 2"), 2);
  EXPECT_EQ(second_document_line("a: 1\n---"), 2);
  EXPECT_EQ(second_document_line("a: 1\n...\n# of the next\nb: 2\n"), 4);
  EXPECT_EQ(second_document_line("a: 'quoted\n--- x'\n"), 2);
}

}  // namespace
}  // namespace kinetrace
