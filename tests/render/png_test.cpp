// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "host/base/file.h"
#include "host/render/image.h"
#include "tests/render/read_png.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

class Png : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "malha_png_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

/// Pixels without repetition.
Image pattern(int width, int height) {
  Image image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) image.pixels.push_back(static_cast<unsigned char>(i * i * 31 + i * 7));
  return image;
}

TEST_F(Png, DecodesBackToTheSamePixels) {
  const Image image = pattern(37, 21);
  write_png(folder_ / "a.png", image);
  const std::string bytes = read_whole(folder_ / "a.png");
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const Image back = read_png(bytes);
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 21);
  EXPECT_EQ(back.pixels, image.pixels);
}

TEST_F(Png, ErrorsNameTheFileAndLeaveNothing) {
  try {
    write_png(folder_ / "absent" / "a.png", pattern(4, 4));
    FAIL() << "wrote into a folder that is not there";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), (folder_ / "absent" / "a.png").string() + ": cannot write: No such file or directory");
  }
  fs::create_symlink("/dev/full", folder_ / "b.png.tmp");  // refuses every byte
  try {
    write_png(folder_ / "b.png", pattern(4, 4));
    FAIL() << "wrote to a full disk";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), (folder_ / "b.png").string() + ": cannot write: No space left on device");
  }
  EXPECT_THROW(write_png(folder_ / "c.png", Image{}), std::invalid_argument);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(ContactSheet, PutsImagesInReadingOrderWithMarginsAround) {
  std::vector<Image> images;
  for (int i = 0; i < 3; ++i) {
    images.push_back({20, 10, std::vector<unsigned char>(20 * 10 * 3, static_cast<unsigned char>(50 * i))});
  }
  images[2] = {10, 10, std::vector<unsigned char>(10 * 10 * 3, 100)};  // narrower: centred
  const Image sheet = contact_sheet(images, 2);
  const int margin = 2;
  ASSERT_EQ(sheet.width, 2 * 20 + 3 * margin);
  ASSERT_EQ(sheet.height, 2 * 10 + 3 * margin);
  for (int y = 0; y < sheet.height; ++y) {
    for (int x = 0; x < sheet.width; ++x) {
      const bool top = y >= 2 && y < 12, bottom = y >= 14 && y < 24;
      int expected = 255;
      if (top && x >= 2 && x < 22) expected = 0;
      if (top && x >= 24 && x < 44) expected = 50;
      if (bottom && x >= 7 && x < 17) expected = 100;
      for (int k = 0; k < 3; ++k) ASSERT_EQ(sheet.pixels[3 * (y * sheet.width + x) + k], expected) << x << " " << y;
    }
  }
  EXPECT_EQ(contact_sheet({}, 2).width, 0);
  EXPECT_EQ(contact_sheet(images, 9).width, 3 * 20 + 4 * margin);  // no empty columns
  EXPECT_THROW(contact_sheet(images, 0), std::invalid_argument);
}

}  // namespace
}  // namespace malha
