"""How much is measured on a GPU."""

from __future__ import annotations

from dataclasses import dataclass, replace

#: Arithmetic of octant, and of OpenMM on a GPU.
OCTANT = ("mixed", "double")
OPENMM = ("single", "mixed")

#: The liquid itself, and what it is compared with.
PLAIN = "lj"
SCENES = ("morse", "two-types", "sums")


@dataclass(frozen=True)
class Plan:
    """Sizes, rounds and time; the defaults are those of the results in the repository."""

    #: Cubes: elsewhere axes have scales of their own, which costs a large scene some percent.
    sizes: tuple[int, ...] = (4_000, 32_000, 131_072, 256_000, 1_000_188, 8_193_532, 16_078_716, 64_012_032)
    rounds: int = 3
    #: Up to this many atoms OpenMM runs beside; larger ones take octant's own rounds within one call.
    turns: int = 1_100_000
    #: The scenes are compared at the largest size up to this.
    scene_size: int = 1_100_000
    #: Steps that melt OpenMM's crystal, as many as octant's.
    melting: int = 2_000
    #: Seconds of a leg of OpenMM.
    leg: float = 0.7
    #: Atoms whose forces in OpenMM are compared, up to so many atoms and above.
    checked: tuple[int, int, int] = (4_000, 500, 100)
    backend: str = "cuda"
    #: Seconds for everything.
    limit: float = 470.0
    #: Further words for ``octant bench``.
    words: tuple[str, ...] = ()

    @classmethod
    def quick(cls) -> Plan:
        """A minute at most: shows that everything works; its numbers are worth nothing."""
        return cls(sizes=(4_000, 32_000), rounds=1, leg=0.1, words=("--steps", "100"))

    def changed(
        self,
        sizes: list[int] | None = None,
        backend: str | None = None,
        limit: float | None = None,
        rounds: int | None = None,
    ) -> Plan:
        """The plan with what the command line says otherwise."""
        given = {"backend": backend, "limit": limit, "rounds": rounds, "sizes": tuple(sorted(sizes)) if sizes else None}
        return replace(self, **{name: value for name, value in given.items() if value is not None})

    def checked_atoms(self, atoms: int) -> int:
        """Atoms of OpenMM's liquid whose forces are compared with sums over all pairs."""
        bound, small, large = self.checked
        return min(atoms, small if atoms <= bound else large)
