#include "sgraph_slam/core/params/params_io.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "sgraph_slam/core/pipeline/params.hpp"

namespace sgraph {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Inner {
  double leaf = 0.1;
  int count = 3;
  void describe(ParamVisitor& v) {
    v.field("leaf", leaf, "m", {0, 10}, "Voxel edge.");
    v.field("count", count, "", {1, 200}, "How many.");
  }
};

struct Outer {
  bool on = true;
  std::string title = "a b: \"c\" #d";
  std::string kind = "none";
  Inner inner;
  void describe(ParamVisitor& v) {
    v.group("top", "All of it.", [this](ParamVisitor& t) {
      t.field("on", on, "A switch.");
      t.field("title", title, "Free text.");
      t.choice("kind", kind, {"none", "some"}, "One | of two.");
      t.group("inner", inner, "Nested.");
    });
  }
};

Describe describing(Outer& params) {
  return [&params](ParamVisitor& v) { params.describe(v); };
}

std::vector<std::string> errors_of(const ParamValues& values) {
  Outer params;
  try {
    apply_values(values, describing(params));
  } catch (const ParamError& error) {
    return error.errors();
  }
  return {};
}

class YamlFile {
 public:
  explicit YamlFile(const std::string& text)
      : path_(std::filesystem::temp_directory_path() / ("params_io_test." + std::to_string(getpid()) + ".yaml")) {
    std::ofstream(path_) << text;
  }
  ~YamlFile() { std::filesystem::remove(path_); }
  [[nodiscard]] std::string path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::vector<std::string> yaml_errors(const std::string& text) {
  const YamlFile file(text);
  try {
    read_yaml_values(file.path());
  } catch (const ParamError& error) {
    return error.errors();
  }
  return {};
}

TEST(Params, ValuesReachTheirFields) {
  Outer params;
  apply_values({{"top.on", "off"}, {"top.title", ""}, {"top.kind", "some"}, {"top.inner.leaf", "2.5e-1"}, {"top.inner.count", "+7"}},
               describing(params));
  EXPECT_FALSE(params.on);
  EXPECT_EQ(params.title, "");
  EXPECT_EQ(params.kind, "some");
  EXPECT_DOUBLE_EQ(params.inner.leaf, 0.25);
  EXPECT_EQ(params.inner.count, 7);
}

TEST(Params, WhatIsNotGivenKeepsItsDefault) {
  Outer params;
  apply_values({}, describing(params));
  EXPECT_EQ(params.inner.count, 3);
  EXPECT_TRUE(params.on);
}

TEST(Params, EveryErrorIsListedAtOnce) {
  EXPECT_THAT(errors_of({{"top.on", "maybe"},
                         {"top.kind", "all"},
                         {"top.inner.leaf", "10.5"},
                         {"top.inner.count", "2.5"},
                         {"top.inner.laef", "1"},
                         {"quite_elsewhere", "1"}}),
              ElementsAre("top.on: \"maybe\" is neither true nor false", "top.kind: \"all\" is none of none, some",
                          "top.inner.leaf: 10.5 is outside 0..10 m", "top.inner.count: \"2.5\" is not a whole number",
                          "unknown parameter quite_elsewhere", "unknown parameter top.inner.laef; did you mean top.inner.leaf?"));
}

TEST(Params, ANameInTheWrongGroupIsRecognised) {
  EXPECT_THAT(errors_of({{"leaf", "1"}}), ElementsAre("unknown parameter leaf; did you mean top.inner.leaf?"));
  EXPECT_THAT(errors_of({{"other.count", "1"}}), ElementsAre("unknown parameter other.count; did you mean top.inner.count?"));
  EXPECT_THAT(errors_of({{"tilte", "1"}}), ElementsAre("unknown parameter tilte; did you mean top.title?"));
}

TEST(Params, NumbersMustBeFiniteAndWhole) {
  for (const char* text : {"nan", "inf", "-inf", "", " 1", "1 ", "1m", "0x1", "--1"})
    EXPECT_EQ(errors_of({{"top.inner.leaf", text}}).size(), 1U) << text;
  for (const char* text : {"nan", "", "3.0", "1e2", "99999999999999"}) EXPECT_EQ(errors_of({{"top.inner.count", text}}).size(), 1U) << text;
  for (const char* text : {"0", "10", "1e-9", "+.5"}) EXPECT_TRUE(errors_of({{"top.inner.leaf", text}}).empty()) << text;
}

TEST(Params, YamlOfAStructReadsBackAsTheSameStruct) {
  std::mt19937 random(11);
  const std::vector<std::string> titles{"",           "plain", "true", "- x",     "12", "a: b", "#no", "tab\tand \"quote\" \\",
                                        "two\nlines", "~",     "null", "\xc3\xa9"};
  for (const std::string& title : titles) {
    Outer params;
    params.title = title;
    params.on = random() % 2 == 0;
    params.inner.leaf = std::uniform_real_distribution<double>(0, 10)(random);
    params.inner.count = 1 + static_cast<int>(random() % 200);
    const YamlFile file(to_yaml(describing(params)));
    Outer copy;
    copy.title = "other";
    apply_values(read_yaml_values(file.path()), describing(copy));
    EXPECT_EQ(copy.title, params.title);
    EXPECT_EQ(copy.on, params.on);
    EXPECT_EQ(copy.inner.leaf, params.inner.leaf);
    EXPECT_EQ(copy.inner.count, params.inner.count);
  }
}

TEST(Params, YamlErrorsNameFileAndLine) {
  EXPECT_THAT(yaml_errors("a:\n  b: [1, 2]\n  c:\n  d: 1\n  d: 2\n"),
              ElementsAre(HasSubstr("line 2: a.b is a list"), HasSubstr("a.c has no value"), HasSubstr("line 5: a.d is given twice")));
  EXPECT_THAT(yaml_errors("a: 1\nb: [1, 2\n"), ElementsAre(HasSubstr("line 3: ")));
  EXPECT_THAT(yaml_errors("- 1\n"), ElementsAre(HasSubstr("expected names with values")));
  EXPECT_TRUE(yaml_errors("").empty());
  EXPECT_TRUE(yaml_errors("# nothing but a comment\n").empty());
  EXPECT_THROW(read_yaml_values("/nonexistent/params.yaml"), ParamError);
}

TEST(Params, FlatAndNestedNamesAreTheSame) {
  const YamlFile nested("a:\n  b: 1\n");
  const YamlFile dotted("a.b: 1\n");
  EXPECT_EQ(read_yaml_values(dotted.path()), (ParamValues{{"a.b", "1"}}));
}

TEST(Params, AssignmentsOverwriteWhatTheFileSays) {
  ParamValues values{{"a", "1"}};
  set_value(values, "a=2=3");
  set_value(values, "b=");
  EXPECT_EQ(values, (ParamValues{{"a", "2=3"}, {"b", ""}}));
  EXPECT_THROW(set_value(values, "a"), ParamError);
  EXPECT_THROW(set_value(values, "=1"), ParamError);
}

TEST(Params, MarkdownHasARowAField) {
  Outer params;
  const std::string text = to_markdown(describing(params));
  EXPECT_THAT(text, HasSubstr("## `top`\n\nAll of it.\n\n| name | default |"));
  EXPECT_THAT(text, HasSubstr("| `top.kind` | none |  | none, some | One \\| of two. |"));
  EXPECT_THAT(text, HasSubstr("### `top.inner`\n\nNested.\n\n| name |"));
  EXPECT_THAT(text, HasSubstr("| `top.inner.leaf` | 0.1 | m | 0 .. 10 | Voxel edge. |"));
}

// What the package ships must pass its own rules.
TEST(Params, TheDefaultsAreWithinTheirRanges) {
  Params params;
  const Describe describe = [&params](ParamVisitor& v) { params.describe(v); };
  const YamlFile file(to_yaml(describe));
  EXPECT_NO_THROW(apply_values(read_yaml_values(file.path()), describe));
}

TEST(Params, TheDocumentationIsCurrent) {
  std::ifstream file("docs/parameters.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_TRUE(text.str() == parameters_page()) << "bring it up to date: rosrun sgraph_slam parameters markdown > docs/parameters.md";
}

}  // namespace
}  // namespace sgraph
