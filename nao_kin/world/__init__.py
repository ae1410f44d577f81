"""The robot in its world: balance on the floor."""

from nao_kin.world.balance import Balance, balance, feet_frame, margin

__all__ = ["Balance", "balance", "feet_frame", "margin"]
