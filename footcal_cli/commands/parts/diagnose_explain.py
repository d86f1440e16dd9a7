"""What one effect is, for ``diagnose --explain``."""

from __future__ import annotations


def explained(name: str) -> str:
    """Formula, source, look-alikes and remedy of an effect."""
    from footcal_cli.core.effects import UnknownEffectError, find_effect
    from footcal_cli.errors import UsageError

    try:
        effect = find_effect(name)
    except UnknownEffectError as error:
        raise UsageError(
            f"no effect named '{name}'",
            remedy=f"did you mean '{error.nearest}'?" if error.nearest else "see footcal effects",
        ) from None
    sizes = ", ".join(f"{p.name} ({p.unit})" for p in effect.parameters)
    return "\n".join(
        (
            f"{effect.name}: {effect.formula}",
            f"  parameters   {sizes}",
            f"  seen in      {', '.join(effect.experiments)}",
            f"  looks like   {', '.join(effect.mimics) or 'nothing else in the table'}",
            f"  separated by {effect.separates or '–'}",
            f"  what to do   {effect.remedy}",
            f"  source       {effect.source}",
        )
    )
