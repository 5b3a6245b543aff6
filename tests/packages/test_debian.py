#!/usr/bin/env python3
"""The Debian packages install, work and go without a trace in a bare root of their own.

    test_debian.py BUILD_DIR

As root in a chroot made of what this machine has installed (throwaway_root.py): no network, and what a package
does not say it needs is not there. Who is not root has the packages built and read, and is told what was not tried: all
that was tried was right, and it exits with NOT_TRIED, which ctest counts as skipped.
"""
import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import throwaway_root
from programs import PORT, ROOT, use_it_in_your_program

sys.path.append(str(ROOT / "tests/support"))
from served import Served  # noqa: E402

NOT_TRIED = 77
BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
PACKAGES = ("libseaway0", "libseaway-dev", "seaway-server", "seaway-tools")
COMPILER = ("gcc", "g++", "libc6-dev", "pkg-config")  # what a user of the development package has besides


def said(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        said("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder.name)
        cls.files = {path.name.split("_")[0]: path for path in pathlib.Path(cls.folder.name).glob("*.deb")}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def field(self, package, name):
        return said("dpkg-deb", "-f", self.files[package], name).strip()

    def contents(self, package):
        return said("dpkg-deb", "-c", self.files[package])

    def test_four_packages_say_what_they_need(self):
        self.assertEqual(sorted(self.files), sorted(PACKAGES))
        for package in PACKAGES:
            self.assertEqual(self.field(package, "Package"), package)
            self.assertTrue(self.field(package, "Description"))
        for package in ("libseaway0", "seaway-server", "seaway-tools"):
            needed = self.field(package, "Depends")
            for library in ("libc6 (>=", "libstdc++6 (>=", "libssl3", "libzstd1"):
                self.assertIn(library, needed, f"{package}: found by dpkg-shlibdeps")
        self.assertEqual(self.field("libseaway-dev", "Depends"),
                         f"libseaway0 (= {self.field('libseaway0', 'Version')})")
        for package in PACKAGES:
            for line in self.contents(package).splitlines():
                self.assertRegex(line, r" root/root .* \./(?:usr/|etc/|$|etc$|usr$)", "belongs to root, below usr or etc")

    def test_each_says_whose_it_is_and_since_when(self):
        for package in PACKAGES:
            documents = self.unpacked(package) / "usr/share/doc" / package
            changes = gzip.decompress((documents / "changelog.Debian.gz").read_bytes()).decode()
            self.assertTrue(changes.startswith(f"seaway ({self.field(package, 'Version')}) "), changes)
            self.assertIn(f"\n -- {self.field(package, 'Maintainer')}  ", changes)
            rights = (documents / "copyright").read_text()
            for stated in ("/usr/share/common-licenses/Apache-2.0", "MetOcean Solutions Ltd", "Permission is hereby granted"):
                self.assertIn(stated, rights)

    def test_who_is_linked_with_the_library_needs_its_package(self):
        """By dpkg-shlibdeps, as a package of another program is made."""
        library = self.unpacked("libseaway0") / "usr/lib"
        folder = pathlib.Path(self.folder.name)
        control = folder / "other/debian/control"
        control.parent.mkdir(parents=True)
        control.write_text("Source: boats\n\nPackage: boats\nArchitecture: any\n")
        (folder / "other/DEBIAN").mkdir()
        (shlibs := folder / "other/debian/shlibs.local").write_text(
            said("dpkg-deb", "-I", self.files["libseaway0"], "shlibs"))
        found = subprocess.run(["dpkg-shlibdeps", "-O", f"-L{shlibs}", f"-l{next(library.glob('*/'))}", "-e", BUILD / "bin/example_buoy"],
                               cwd=folder / "other", capture_output=True, text=True)
        version = self.field("libseaway0", "Version").split("-")[0]
        major, minor, _ = (int(number) for number in version.split("."))
        for needed in (f"(>= {version})", f"(<< {major}.{minor + 1}~)"):  # before 1.0 the next minor version is another interface
            self.assertIn(f"libseaway0 {needed}", found.stdout, found.stderr)
        self.assertEqual(said("dpkg-deb", "-I", self.files["libseaway0"], "triggers"), "activate-noawait ldconfig\n")

    def unpacked(self, package):
        folder = pathlib.Path(self.folder.name) / package
        if not folder.exists():
            said("dpkg-deb", "-x", self.files[package], folder)
        return folder

    def test_it_installs_works_and_goes_in_a_bare_root(self):
        refusal = throwaway_root.refusal()
        if refusal:
            print(f"NOT TRIED: to install, run and remove in a root of their own: {refusal}. The packages were "
                  "built and read alone.", file=sys.stderr)
            self.skipTest(refusal)
        needed = [name for package in PACKAGES for one in throwaway_root.names(self.field(package, "Depends"))
                  for name in one if name not in PACKAGES]
        with tempfile.TemporaryDirectory() as folder:
            self.root = throwaway_root.Root(folder, [*needed, *COMPILER])
            before = self.root.files()
            self.install()
            self.serve_and_ask()
            self.remove()
            self.assertEqual(self.root.files() - before, set(), "is left behind")
            self.assertEqual(before - self.root.files(), set(), "is gone that was not ours")

    def inside(self, *command, **options):
        done = self.root.run(*command, **options)
        self.assertEqual(done.returncode, 0, f"{command}: {done.stdout}{done.stderr}")
        return done.stdout

    def user(self):
        return self.root.run("getent", "passwd", "seaway").stdout

    def install(self):
        for package in PACKAGES:  # a test of its own: without what it says it needs it is refused
            (self.root.folder / "tmp" / self.files[package].name).write_bytes(self.files[package].read_bytes())
        refused = self.root.run("dpkg", "-i", f"/tmp/{self.files['libseaway-dev'].name}")
        self.assertIn("depends on libseaway0", refused.stderr)
        self.inside("dpkg", "-r", "libseaway-dev")
        self.inside("dpkg", "-i", *(f"/tmp/{self.files[package].name}" for package in PACKAGES))
        self.assertEqual(self.inside("dpkg", "--audit"), "")
        name, _, number, _, _, home, shell = self.user().strip().split(":")
        self.assertEqual((name, home, shell), ("seaway", "/var/lib/seaway", "/usr/sbin/nologin"))
        self.assertLess(int(number), 1000, "a user of the system")
        enabled = self.root.folder / "etc/systemd/system/multi-user.target.wants/seaway-server.service"
        self.assertTrue(enabled.is_symlink(), "starts with the machine")
        self.a_scene_stays_what_it_was()
        for path in (self.root.folder / "tmp").glob("*.deb"):
            path.unlink()

    def a_scene_stays_what_it_was(self):
        """Also where nobody edited it, and the next version of the package has another: its journal is of this one."""
        scene, shipped = (self.root.folder / path for path in ("etc/seaway/sea.toml", "usr/share/seaway/sea.toml"))
        self.assertEqual(scene.read_bytes(), shipped.read_bytes())
        self.assertNotIn("sea.toml", self.root.run("dpkg-query", "--show", "-f", "${Conffiles}", "seaway-server").stdout)
        first = scene.read_text()
        scene.write_text(first + "# of the version before\n")
        self.inside("dpkg", "-i", f"/tmp/{self.files['seaway-server'].name}")
        self.assertEqual(scene.read_text(), first + "# of the version before\n")

    def serve_and_ask(self):
        """As the unit has it, but for the port and the folder of the journal that systemd makes."""
        self.inside("install", "-d", "-o", "seaway", "-g", "seaway", "/var/lib/seaway")
        self.inside("seaway-server", "/etc/seaway/sea.toml", "--config", "/etc/seaway/seaway-server.toml",
                    "--check", user="seaway")
        enter = ["chroot", "--userspec=seaway:seaway", self.root.folder, "seaway-server"]
        token = self.root.folder / "etc/seaway/admin.token"
        token.write_text("master\n")
        options = ["/etc/seaway/sea.toml", "--device", "native", "--data-dir", "/var/lib/seaway",
                   "--admin-token-file", "/etc/seaway/admin.token"]
        program, commands = use_it_in_your_program()
        with Served(*enter, *options, env=self.root.environment()) as server:
            (self.root.folder / "tmp/height.c").write_text(program.replace(PORT, str(server.port)))
            out = [self.inside("sh", "-c", f"cd /tmp && {command}") for command in commands]
            self.examples_compile_as_they_say(server.port)
            asked = self.inside("seaway-query", f"ws://127.0.0.1:{server.port}", "--at", "12,-40")
            self.a_variant_is_loaded_and_another_sea_is_not(server.port)
        token.unlink()
        self.assertRegex(out[-1], r"^-?\d+\.\d\d m \n$")
        self.assertIn("12", asked)
        shutil.rmtree(self.root.folder / "tmp")
        (self.root.folder / "tmp").mkdir(mode=0o1777)
        self.assertTrue((self.root.folder / "var/lib/seaway/journal.sqlite").is_file())

    def a_variant_is_loaded_and_another_sea_is_not(self, port):
        """As docs/install.md says."""
        sea = (self.root.folder / "etc/seaway/sea.toml").read_text()
        variant = sea.replace("wind_speed_10m_mps = 19.0", "wind_speed_10m_mps = 17.0")
        self.assertNotEqual(variant, sea)
        (self.root.folder / "tmp/variant.toml").write_text(variant)
        load = ("seaway-ctl", f"ws://127.0.0.1:{port}", "--token-file", "/etc/seaway/admin.token", "load")
        self.inside(*load, "/tmp/variant.toml")
        other = self.root.run(*load, "/usr/share/seaway/scenes/calm.toml")
        self.assertEqual(other.returncode, 6, other.stdout + other.stderr)
        self.assertIn("cannot change while the sea runs", other.stderr)

    def examples_compile_as_they_say(self, port):
        """By the command at the head of each; the buoy then floats for a second."""
        folder = "usr/share/doc/libseaway-dev/examples"
        for name in ("buoy.c", "ship.cpp", "fleet.cpp"):
            head = (self.root.folder / folder / name).read_text()
            command = re.search(r"^(?: \*|//)     (c(?:c|\+\+) .*)$", head, re.M).group(1)
            self.inside("sh", "-c", f"cp -r /{folder}/. /tmp && cd /tmp && {command}")
        self.assertIn("time_s,water_m", self.inside("/tmp/buoy", f"ws://127.0.0.1:{port}", "1"))

    def remove(self):
        scene = self.root.folder / "etc/seaway/sea.toml"
        scene.write_text(scene.read_text() + "# mine\n")
        self.inside("dpkg", "-r", *PACKAGES)
        self.assertTrue(self.user(), "the journal is still somebody's")
        self.assertTrue((self.root.folder / "var/lib/seaway/journal.sqlite").is_file())
        self.assertIn("# mine", scene.read_text())
        cache = self.root.folder / "var/cache/seaway"
        cache.mkdir()
        (cache / "kernels.tsv").write_text("")
        self.inside("dpkg", "-P", *PACKAGES)
        self.assertEqual(self.user(), "")
        self.assertEqual(self.root.run("getent", "group", "seaway").stdout, "")
        for path in ("var/lib/seaway", "var/cache/seaway", "etc/seaway", "etc/systemd/system/multi-user.target.wants/seaway-server.service"):
            self.assertFalse((self.root.folder / path).exists(), path)
        self.assertNotIn("seaway", self.inside("dpkg-query", "-W"))


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(NOT_TRIED if result.skipped else 0)
