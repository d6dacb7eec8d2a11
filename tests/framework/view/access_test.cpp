// SPDX-License-Identifier: Apache-2.0
// Who may talk to the viewer.
#include "lucarium/view/access.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <set>
#include <string>
#include <vector>

using namespace lucarium;

TEST_CASE("tokens are 32 hexadecimal digits, and no two are alike") {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = make_view_token();
    CHECK(token.size() == 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
    tokens.insert(token);
  }
  CHECK(tokens.size() == 100);
  CHECK(same_token("abc", "abc"));
  for (const char* other : {"", "ab", "abcd", "abd", "bbc", "ABC"}) CHECK_FALSE(same_token(other, "abc"));
}

TEST_CASE("addresses and this machine's names are hosts of ours, others are not") {
  char own[256] = {};
  REQUIRE(::gethostname(own, sizeof own - 1) == 0);
  for (const std::string& host : std::vector<std::string>{"127.0.0.1", "127.0.0.1:8080", "localhost:1", "LocalHost",
                                                          "[::1]:80", "[::1]", "192.168.1.20:8080", own})
    CHECK_MESSAGE(is_host_allowed(host), host);
  for (const std::string& host :
       std::vector<std::string>{"", "evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil",
                                "127.0.0.1:80x", "[::1", "::1", "127.0.0.1:80:80", "local host"})
    CHECK_FALSE_MESSAGE(is_host_allowed(host), host);
}

TEST_CASE("a WebSocket is the page's own where its Origin is the host that it was sent to") {
  CHECK(is_origin_allowed("http://127.0.0.1:8080", "127.0.0.1:8080"));
  for (const char* origin : {"", "null", "http://evil.example", "https://127.0.0.1:8080", "http://127.0.0.1:8081",
                             "http://127.0.0.1", "127.0.0.1:8080"})
    CHECK_FALSE_MESSAGE(is_origin_allowed(origin, "127.0.0.1:8080"), origin);
  CHECK_FALSE(is_origin_allowed("http://", ""));
}
