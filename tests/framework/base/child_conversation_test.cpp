// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/child_conversation.h"

#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <thread>

#include "lucarium/base/error.h"

using namespace lucarium;

TEST_CASE("a child answers line by line, long ones and empty ones, too") {
  ChildConversation child({"cat"});
  const std::string lines[] = {"one", "", std::string(100000, 'x'), "two words"};
  for (const std::string& line : lines) {
    std::string answer = "unchanged";
    REQUIRE(child.ask(line, answer));
    CHECK(answer == line);
  }
}

TEST_CASE("two lines in one answer are two answers") {
  ChildConversation child({"sh", "-c", "read first; printf 'a\\nb\\n'; cat"});
  std::string answer;
  REQUIRE(child.ask("go", answer));
  CHECK(answer == "a");
  REQUIRE(child.ask("on", answer));
  CHECK(answer == "b");
}

TEST_CASE("a child that is gone is noticed and no signal ends this process") {
  ChildConversation child({"sh", "-c", "read first; echo enough; exit 0"});
  std::string answer;
  REQUIRE(child.ask("go", answer));
  CHECK(answer == "enough");
  for (int i = 0; i < 3; ++i) CHECK(!child.ask("on", answer));
}

TEST_CASE("who waits for an answer hears that the child was ended") {
  ChildConversation child({"sh", "-c", "read first; exec sleep 600"});
  std::thread ending([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    child.kill();
  });
  std::string answer;
  CHECK(!child.ask("go", answer));
  ending.join();
}

TEST_CASE("a child that cannot be started is an error") {
  CHECK_THROWS_WITH_AS(ChildConversation({"/nowhere/to/be/found"}),
                       "cannot start /nowhere/to/be/found: No such file or directory", Error);
}
