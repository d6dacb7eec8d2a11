// SPDX-License-Identifier: Apache-2.0
// Pages and the renderer meet in the hub: who controls, what is wanted, who gets which picture.
#include "lucarium/view/hub.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <thread>

#include "lucarium/base/json.h"

using namespace lucarium;
using nlohmann::json;

namespace {

/// Everything that waits for the page: texts as JSON, pictures as {"picture": length}.
std::vector<json> take_all(ViewHub& hub, uint64_t page) {
  std::vector<json> all;
  while (const std::optional<ViewHub::Outgoing> next = hub.next(page))
    all.push_back(next->binary ? json{{"picture", next->data->size()}} : json::parse(*next->data));
  return all;
}

bool has_error(const std::vector<json>& messages) {
  return std::any_of(messages.begin(), messages.end(), [](const json& m) { return m.contains("error"); });
}

}  // namespace

TEST_CASE("the first page controls, others watch until they take control or are left alone") {
  ViewHub hub;
  hub.set_welcome(R"({"view": 1})");
  const uint64_t first = *hub.join(), second = *hub.join();
  CHECK(take_all(hub, first).back() == json{{"control", true}, {"pages", 2}});
  const std::vector<json> told = take_all(hub, second);
  CHECK(told.front() == json{{"view", 1}});
  CHECK(told.back() == json{{"control", false}, {"pages", 2}});

  hub.receive(second, R"({"do": "pause", "on": true})");
  CHECK(has_error(take_all(hub, second)));
  CHECK_FALSE(hub.request().paused);
  hub.receive(first, R"({"do": "pause", "on": true})");
  CHECK(take_all(hub, first).empty());
  CHECK(hub.request().paused);

  hub.receive(second, R"({"do": "control", "id": 3})");
  CHECK(take_all(hub, second) == std::vector<json>{{{"control", true}, {"pages", 2}}, {{"answer", 3}}});
  hub.receive(first, R"({"do": "pause", "on": false})");
  CHECK(has_error(take_all(hub, first)));
  hub.leave(second);
  CHECK(take_all(hub, first).back() == json{{"control", true}, {"pages", 1}});
  hub.leave(first);
  CHECK(hub.pages() == 0);
  CHECK_FALSE(hub.next(first));
}

TEST_CASE("a page that shows nothing gets two pictures and then none, and the others go on") {
  ViewHub hub;
  const uint64_t sleeping = *hub.join(), awake = *hub.join();
  take_all(hub, sleeping);
  take_all(hub, awake);
  size_t of_sleeping = 0, of_awake = 0;
  for (uint64_t number = 1; number <= 10; ++number) {
    CHECK(hub.wants_picture());
    hub.set_picture(0, number, std::string(number, 'p'));
    of_sleeping += take_all(hub, sleeping).size();
    const std::vector<json> pictures = take_all(hub, awake);
    REQUIRE(pictures.size() == 1);
    CHECK(pictures[0]["picture"] == number);
    ++of_awake;
    hub.receive(awake, json{{"do", "shown"}, {"picture", number}}.dump());
  }
  CHECK(of_sleeping == 2);
  CHECK(of_awake == 10);
  hub.receive(sleeping, R"({"do": "shown", "picture": 2})");  // it wakes up: the last one, not those it missed
  CHECK(take_all(hub, sleeping) == std::vector<json>{{{"picture", 10}}});
  hub.receive(sleeping, R"({"do": "shown", "picture": 11})");
  CHECK(has_error(take_all(hub, sleeping)));
}

TEST_CASE("pictures of several slots come in their order, each slot's last one") {
  ViewHub hub;
  const uint64_t page = *hub.join();
  take_all(hub, page);
  hub.set_picture(0, 1, "1");
  hub.set_picture(1, 2, "22");
  hub.set_picture(0, 3, "333");  // the first one was not taken in time
  CHECK(take_all(hub, page) == std::vector<json>{{{"picture", 2}}, {{"picture", 3}}});
  hub.set_picture(1, 4, "4444");
  CHECK(take_all(hub, page).empty());  // two are on the way
  hub.receive(page, R"({"do": "shown", "picture": 3})");
  CHECK(take_all(hub, page) == std::vector<json>{{{"picture", 4}}});
}

TEST_CASE("sides have techniques of their own") {
  ViewHub hub;
  const uint64_t page = *hub.join();
  hub.receive(page, R"({"do": "technique", "name": "a", "parameters": []})");
  hub.receive(page, R"({"do": "technique", "name": "b", "parameters": [["c", "1"]], "side": 1})");
  hub.receive(page, R"({"do": "beside", "as": "flip"})");
  ViewRequest request = hub.request();
  CHECK(request.sides[0].technique == "a");
  CHECK(request.sides[1].technique == "b");
  CHECK(request.sides[1].parameters.size() == 1);
  CHECK((request.beside && request.flip));
  hub.receive(page, R"({"do": "beside", "as": "pictures"})");
  request = hub.request();
  CHECK((request.beside && !request.flip));
  hub.receive(page, R"({"do": "beside", "as": "none"})");
  CHECK_FALSE(hub.request().beside);
}

TEST_CASE("where nobody has room for a picture none is wanted") {
  ViewHub hub;
  CHECK_FALSE(hub.wants_picture());
  const uint64_t page = *hub.join();
  for (uint64_t number = 1; number <= 2; ++number) {
    CHECK(hub.wants_picture());
    hub.set_picture(0, number, "p");
    take_all(hub, page);
  }
  CHECK_FALSE(hub.wants_picture());
  hub.leave(page);
  CHECK_FALSE(hub.wants_picture());
}

TEST_CASE("what is asked for becomes the request, and grows its numbers") {
  ViewHub hub;
  const uint64_t page = *hub.join();
  const uint64_t changes = hub.changes();
  hub.receive(page, R"({"do": "camera", "eye": [1, 2, 3], "target": [0, 0, 0], "vfov": 30})");
  hub.receive(page, R"({"do": "technique", "name": "x", "parameters": [["a", "1"]]})");
  hub.receive(page, R"({"do": "layer", "name": "direct"})");
  hub.receive(page, R"({"do": "restart"})");
  hub.receive(page, R"({"do": "save", "kind": "png", "exposure": 2})");
  const ViewRequest request = hub.request();
  REQUIRE(request.camera);
  CHECK(request.camera->eye == glm::vec3(1, 2, 3));
  CHECK(request.sides[0].technique == "x");
  CHECK(request.layer == "direct");
  CHECK(request.restart_number == 1);
  CHECK(hub.changes() == changes + 2);
  const std::vector<ViewSave> saves = hub.take_saves();
  REQUIRE(saves.size() == 1);
  CHECK(saves[0].page == page);
  CHECK(saves[0].kind == "png");
  CHECK(hub.take_saves().empty());
  hub.receive(page, R"({"do": "scene_camera", "index": 2})");
  CHECK_FALSE(hub.request().camera);
  CHECK(hub.request().scene_camera == 2);
}

TEST_CASE("too many messages at once are refused, and too many pages") {
  ViewHub hub;
  const uint64_t page = *hub.join();
  take_all(hub, page);
  size_t answers = 0;
  for (int i = 0; i < 5000; ++i) {
    hub.receive(page, R"({"do": "pause", "on": true})");
    answers += take_all(hub, page).size();
  }
  CHECK(answers > 1000);
  for (int i = 0; i < 5000; ++i) hub.receive(page, "nonsense");
  CHECK(take_all(hub, page).size() <= 64);
  for (size_t i = 1; i < ViewHub::max_pages; ++i) CHECK(hub.join());
  CHECK_FALSE(hub.join());
}

TEST_CASE("a page that takes nothing holds no more than a little") {
  ViewHub hub;
  const uint64_t asleep = *hub.join();
  // What the last of its kind makes void waits once.
  for (int i = 0; i < 1000; ++i) {
    hub.set_scene(R"({"scene": )" + std::to_string(i) + "}");
    hub.set_welcome(R"({"view": )" + std::to_string(i) + "}");
    hub.set_notice("something");
    hub.leave(*hub.join());
  }
  // Files wait up to a quarter of a gigabyte, or one that is larger.
  const std::string file(size_t{100} << 20, 'x');
  for (int i = 0; i < 8; ++i) hub.send_file(asleep, file);
  const std::vector<json> waiting = take_all(hub, asleep);
  const auto count = [&](const char* key) {
    return std::count_if(waiting.begin(), waiting.end(), [&](const json& m) { return m.contains(key); });
  };
  CHECK(count("scene") == 1);
  CHECK(count("view") == 1);
  CHECK(count("control") == 1);
  CHECK(count("picture") == 2);
  CHECK(waiting.size() <= 70);
  for (const json& message : waiting) {
    if (message.contains("scene")) CHECK(message["scene"] == 999);
    if (message.contains("control")) CHECK(message["pages"] == 1);
  }
  hub.send_file(asleep, file);  // all were taken: there is room again
  CHECK(take_all(hub, asleep).size() == 1);
}

TEST_CASE("two threads use the hub at once") {
  ViewHub hub;
  std::atomic<bool> ended{false};
  std::atomic<int> woken{0};
  hub.on_news([&woken] { ++woken; });
  std::thread renderer([&] {
    for (uint64_t number = 1; !ended; ++number) {
      hub.wait(std::chrono::milliseconds(1));
      if (hub.wants_picture()) hub.set_picture(0, number, std::string(100, 'p'));
      hub.set_status("{}");
      for (const ViewSave& save : hub.take_saves()) hub.send_file(save.page, "file");
    }
  });
  size_t files = 0;
  for (int round = 0; round < 50; ++round) {
    const uint64_t page = *hub.join();
    hub.receive(page, R"({"do": "save", "kind": "png", "exposure": 0})");
    for (bool done = false; !done;) {
      while (const std::optional<ViewHub::Outgoing> next = hub.next(page))
        done |= next->binary && *next->data == "file";
      std::this_thread::yield();
    }
    ++files;
    hub.leave(page);
  }
  ended = true;
  renderer.join();
  CHECK(files == 50);
  CHECK(woken > 50);
}
