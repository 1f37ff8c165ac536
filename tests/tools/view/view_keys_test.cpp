// SPDX-License-Identifier: Apache-2.0
// Keys that are pressed faster than pictures are drawn are handled in order, and none is lost.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/numbers.h"
#include "tools/view/keys.h"

namespace malha {
namespace {

using view::Input;
using view::InputQueue;

constexpr int kCtrl = 341;

Input key(int code, bool down) {
  return {code == kCtrl ? Input::Kind::Modifier : Input::Kind::Key, code, down, 0, 0, down};
}

/// The keys as a program reads them that polls once a picture, as Dear ImGui does: those pressed since the last
/// picture, after "^" where Ctrl is down.
struct Looker {
  std::set<int> down, before;
  std::string seen;
  void look(const std::vector<Input>& inputs) {
    for (const Input& input : inputs) {
      if (input.kind == Input::Kind::Letter || input.kind == Input::Kind::Button) continue;
      if (input.presses)
        down.insert(input.code);
      else
        down.erase(input.code);
    }
    for (const int code : down)
      if (code != kCtrl && !before.contains(code))
        seen += (down.contains(kCtrl) ? "^" : "") + std::string(1, char(code));
    before = down;
  }
};

TEST(ViewKeys, AreAllHandledHoweverFastTheyAre) {
  InputQueue keys;
  for (const int code : {kCtrl, int('A')}) keys.add(key(code, true));
  for (const int code : {int('A'), kCtrl}) keys.add(key(code, false));
  for (const int code : {'4', '0', '0', 'E'}) keys.add(key(code, true)), keys.add(key(code, false));
  Looker looker;
  while (keys.has_pending()) looker.look(keys.of_next_frame());
  EXPECT_EQ(looker.seen, "^A400E");
  EXPECT_TRUE(looker.down.empty());
}

TEST(ViewKeys, GoTogetherWithTheLettersAndClicksThatTheyGoWith) {
  InputQueue keys;
  keys.add(key(kCtrl, true));
  keys.add({Input::Kind::Button, 0, 1, 0, 0, true});
  keys.add(key(kCtrl, false));
  const std::vector<Input> first = keys.of_next_frame();
  ASSERT_EQ(first.size(), 2u) << "Ctrl is down while the button is seen";
  EXPECT_EQ(keys.of_next_frame().size(), 1u);
  keys.add(key('A', true)), keys.add({Input::Kind::Letter, 'a'});
  keys.add(key('B', true)), keys.add({Input::Kind::Letter, 'b'});
  EXPECT_EQ(keys.of_next_frame().size(), 2u) << "a key and its letter";
  EXPECT_EQ(keys.of_next_frame().back().code, 'b');
  EXPECT_FALSE(keys.has_pending());
}

TEST(ViewKeys, OfARandomTypistAreHandledInOrder) {
  Random random(4);
  InputQueue keys;
  Looker looker;
  std::string typed;
  for (int k = 0; k < 300; ++k) {
    const int code = 'A' + random.below(5);
    const bool ctrl = random.below(4) == 0;
    if (ctrl) keys.add(key(kCtrl, true));
    keys.add(key(code, true)), keys.add(key(code, false));
    if (ctrl) keys.add(key(kCtrl, false));
    typed += (ctrl ? "^" : "") + std::string(1, char(code));
    if (random.below(3) == 0) looker.look(keys.of_next_frame());
  }
  while (keys.has_pending()) looker.look(keys.of_next_frame());
  EXPECT_EQ(looker.seen, typed);
}

}  // namespace
}  // namespace malha
