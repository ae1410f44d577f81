"""nao_kin: the kinematics of the NAO humanoid."""
